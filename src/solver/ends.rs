//! How packets end.

use serde::{Deserialize, Serialize};

use crate::transport::End;

/// How the packets of forward chains ended, counted.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Ends {
    /// Absorbed by surfaces.
    pub absorbed: u64,
    /// Absorbed by panes of glass.
    pub panes: u64,
    /// Absorbed by bright balls.
    pub balls: u64,
    /// Absorbed by backs of one-sided surfaces.
    pub back_faces: u64,
    /// Left the scene.
    pub escaped: u64,
    /// Cut off after very many surfaces or past a time limit.
    pub cut_off: u64,
}

impl Ends {
    pub fn count(&mut self, end: End) {
        match end {
            End::Absorbed => self.absorbed += 1,
            End::Pane => self.panes += 1,
            End::Ball => self.balls += 1,
            End::BackFace => self.back_faces += 1,
            End::Escaped => self.escaped += 1,
            End::CutOff => self.cut_off += 1,
        }
    }

    /// All packets.
    pub fn packets(&self) -> u64 {
        self.absorbed + self.panes + self.balls + self.back_faces + self.escaped + self.cut_off
    }
}

impl std::ops::AddAssign for Ends {
    fn add_assign(&mut self, other: Ends) {
        self.absorbed += other.absorbed;
        self.panes += other.panes;
        self.balls += other.balls;
        self.back_faces += other.back_faces;
        self.escaped += other.escaped;
        self.cut_off += other.cut_off;
    }
}
