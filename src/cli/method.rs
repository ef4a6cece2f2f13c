//! The methods, elements and plot formats that `--method`, `--elements` and `--plots` name.

use serde::{Deserialize, Serialize};

use super::exit::Failure;
use crate::output::Language;
use crate::solver::{ElementChoice, Method};

/// How a scene is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MethodChoice {
    /// By chains and walks, and the estimators that use them.
    By(Method),
    /// Finite elements with exact form factors, on closed rooms of rectangles.
    Radiosity,
    /// Visibility averaged over the points of a regular mesh.
    LightMesh,
}

impl MethodChoice {
    /// Leaves the choice of the method to the program.
    pub const AUTO: MethodChoice = MethodChoice::By(Method::Auto);

    fn name(self) -> &'static str {
        match self {
            MethodChoice::By(method) => method.name(),
            MethodChoice::Radiosity => "radiosity",
            MethodChoice::LightMesh => "light-mesh",
        }
    }

    /// The name of a method that traces no chains, so that its error is not random.
    pub fn name_without_chains(self) -> Option<&'static str> {
        match self {
            MethodChoice::Radiosity | MethodChoice::LightMesh => Some(self.name()),
            MethodChoice::By(_) => None,
        }
    }
}

/// Parses a method's name, for clap.
pub fn method(text: &str) -> Result<MethodChoice, String> {
    const THERE: &str = "this version has auto, gather, collision and local (every scene), local-naive (to show why local is not so simple), radiosity (closed diffuse rooms of rectangles) and light-mesh (planes and luminance)";
    // `walk` is the name that results give to a map's indirect light.
    let hint = if text == "walk" { "; collision uses walks for receivers" } else { "" };
    all_methods().find(|choice| choice.name() == text).ok_or_else(|| format!("no such method; {THERE}{hint}"))
}

fn all_methods() -> impl Iterator<Item = MethodChoice> {
    Method::ALL.map(MethodChoice::By).into_iter().chain([MethodChoice::Radiosity, MethodChoice::LightMesh])
}

/// The words that an option accepts, for completion by shells. `None` if the option does not take one of a few words.
pub fn words_of(option: &str) -> Option<Vec<&'static str>> {
    match option {
        "method" => Some(all_methods().map(MethodChoice::name).collect()),
        "elements" => Some(ELEMENT_CHOICES.iter().map(|(name, _)| *name).collect()),
        "plots" => Some(PLOT_WORDS.to_vec()),
        "language" => Some(Language::all().into_iter().map(Language::code).collect()),
        _ => None,
    }
}

/// The choices of elements of a map, by name.
const ELEMENT_CHOICES: [(&str, ElementChoice); 2] =
    [("adaptive", ElementChoice::Adaptive), ("given", ElementChoice::Given)];

/// Parses the choice of elements of a map, for clap.
pub fn elements(text: &str) -> Result<ElementChoice, String> {
    let named = ELEMENT_CHOICES.into_iter().find(|(name, _)| *name == text);
    named.map(|(_, choice)| choice).ok_or_else(|| "elements are adaptive or given".to_owned())
}

/// Formats of plots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plots {
    /// SVG files.
    pub svg: bool,
    /// PNG files.
    pub png: bool,
}

impl Plots {
    /// Whether any plot is requested.
    pub fn any(&self) -> bool {
        self.svg || self.png
    }
}

/// The values of `--plots`: lists of formats, and no plots.
const PLOT_WORDS: [&str; 4] = ["svg", "png", "svg,png", "none"];

/// Parses a list of formats, for clap.
pub fn plots(text: &str) -> Result<Plots, String> {
    if text == "none" {
        return Ok(Plots::default());
    }
    let mut plots = Plots::default();
    for format in text.split(',') {
        match format.trim() {
            "svg" => plots.svg = true,
            "png" => plots.png = true,
            _ => {
                let [words @ .., last] = PLOT_WORDS;
                return Err(format!("write {} or {last}", words.join(", ")));
            }
        }
    }
    Ok(plots)
}

/// The same for other front ends, with the error as a [`Failure`].
///
/// # Errors
///
/// A format that does not exist.
pub fn plots_named(text: &str) -> Result<Plots, Failure> {
    plots(text).map_err(|remedy| Failure::Usage {
        what: "invalid value for plots".to_owned(),
        got: format!("{text:?}"),
        expected: "a value that --plots of luxmc solve accepts".to_owned(),
        remedy,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_read_as_a_list_or_none() {
        assert_eq!(plots("svg,png"), Ok(Plots { svg: true, png: true }));
        assert_eq!(plots("none"), Ok(Plots::default()));
        assert!(plots("").is_err() && plots("svg,none").is_err() && plots("pdf").is_err());
    }

    #[test]
    fn unknown_methods_are_refused_with_those_that_are_there() {
        assert_eq!(method("auto"), Ok(MethodChoice::AUTO));
        assert_eq!(method("gather"), Ok(MethodChoice::By(Method::Gather)));
        assert!(
            method("magic").is_err_and(|message| message.contains("no such method") && message.contains("collision"))
        );
    }
}
