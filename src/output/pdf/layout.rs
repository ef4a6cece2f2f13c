//! Lays blocks out on A4. Nothing is cut, tables continue under their headings, and every page has its number.

use super::drawing;
use super::ink::{A4, Paper, PaperStroke, Type, drawable};
use super::markup::{Figure, PageBlock, PaperTable, TextCell, TextRun};
use crate::output::color::{BLACK, BLUE, FAINT, Ink, SOFT};
use crate::output::font::text_width;

/// Margins in points: left and right, above, below.
const SIDE: f64 = 46.0;
const TOP: f64 = 48.0;
const BOTTOM: f64 = 52.0;
const WIDTH: f64 = A4[0] - 2.0 * SIDE;
const END: f64 = A4[1] - BOTTOM;
/// Type sizes in points; `SMALL` and `LOW` are factors.
const BODY: f64 = 9.6;
const HEADINGS: [f64; 3] = [20.0, 13.0, 10.6];
const ITEM: f64 = 0.95 * BODY;
const TABLE: f64 = 8.6;
const SMALL: f64 = 0.87;
const LOW: f64 = 0.72;
/// Height of a line over its type size.
const LINE: f64 = 1.42;
/// Space below a paragraph over its type size.
const BELOW_WORDS: f64 = 0.45;
/// Indent of the words of a list, in points.
const ITEM_INDENT: f64 = 10.0;
/// Lines of space that must follow the words before a list, so that they do not stand alone.
const LINES_BEFORE_LIST: f64 = 3.0;
/// Smallest space below a heading, in points. A heading with less goes to the next page.
const COMPANY: f64 = 90.0;
/// If at least this space is left, in points, a section that would begin a page may begin on the page before.
const ROOM_TO_GO_ON: f64 = 260.0;
/// Largest heights of pictures in points: alone, side by side, and of pictures that may fill a page.
const ALONE: f64 = 330.0;
const BESIDE: f64 = 205.0;
const TALL: f64 = 500.0;
/// Factors on the size of pictures that are tried, so that the text after the pictures ends on the same page.
const SIZES: [f64; 6] = [1.0, 0.95, 0.9, 0.85, 0.8, 0.75];
/// Gaps between columns of a table, and between pictures, in points.
const GAP: f64 = 9.0;
const GUTTER: f64 = 16.0;
/// Space above and below a row of pictures, in points.
const ABOVE_FIGURES: f64 = 4.0;
const BELOW_FIGURES: f64 = 6.0;
/// Points for a pixel of a picture that is shown at its drawn size.
const POINTS: f64 = 0.75;
/// Smallest type size of a table that is too wide, in points.
const LEAST_TYPE: f64 = 6.0;

/// A word of a line: a piece without a space in it.
#[derive(Clone, Debug)]
struct Word {
    run: TextRun,
    size: f64,
    width: f64,
    /// Whether a space stands before it.
    is_apart: bool,
}

/// The position of the next block.
pub struct Layout {
    paper: Paper,
    page: usize,
    y: f64,
}

impl Layout {
    /// A layout with an empty first page.
    pub fn new() -> Layout {
        let mut paper = Paper::new();
        paper.turn_page();
        Layout { paper, page: 0, y: TOP }
    }

    fn turn(&mut self) {
        self.paper.turn_page();
        (self.page, self.y) = (self.paper.pages() - 1, TOP);
    }

    /// Goes to the next page if this one does not have this height left.
    fn need(&mut self, height: f64) {
        if self.y + height > END && self.y > TOP {
            self.turn();
        }
    }

    /// Places blocks one below the other.
    pub fn place(&mut self, blocks: &[PageBlock]) {
        for (index, block) in blocks.iter().enumerate() {
            match block {
                PageBlock::Heading(level, runs, is_page) => {
                    // A section begins a new page only if it begins with pictures or if little of the page is left.
                    let is_picture = matches!(blocks.get(index + 1), Some(PageBlock::Figures(..)));
                    if *is_page && self.y > TOP && (is_picture || END - self.y < ROOM_TO_GO_ON) {
                        self.turn();
                    }
                    let company = match blocks.get(index + 1) {
                        Some(PageBlock::Figures(figures, tall)) => first_row_height(figures, *tall),
                        Some(PageBlock::Terms(terms)) => terms_height(terms) + BODY * LINE,
                        Some(PageBlock::Heading(..)) => COMPANY + 20.0,
                        _ => COMPANY,
                    };
                    self.heading(*level, runs, company);
                }
                PageBlock::Words(runs) => {
                    if matches!(blocks.get(index + 1), Some(PageBlock::Item(..))) {
                        self.need(LINES_BEFORE_LIST * BODY * LINE);
                    }
                    self.words(runs, BODY, 0.0);
                }
                PageBlock::Item(runs) => self.item(runs),
                PageBlock::Typed(text) => self.typed(text),
                PageBlock::Terms(terms) => self.terms(terms),
                PageBlock::Table(table) => self.table(table),
                PageBlock::Signatures(lines) => self.signatures(lines),
                PageBlock::Figures(figures, tall) => {
                    let size = self.size_of_figures(figures, *tall, &blocks[index..]);
                    self.figures(figures, *tall, size);
                }
            }
        }
    }

    /// The factor on the size of the next pictures. They are reduced if they and the blocks up to the next heading then end on the
    /// page on which they begin. A few words alone on a page are worse than smaller pictures.
    fn size_of_figures(&self, figures: &[Figure], tall: bool, blocks: &[PageBlock]) -> f64 {
        let fitting = |room: f64| {
            SIZES.into_iter().find(|size| height_to_heading(blocks, *size).is_some_and(|height| height <= room))
        };
        let begins_here = self.y + first_row_height(figures, tall) + ABOVE_FIGURES + BELOW_FIGURES <= END;
        let on_next_page = || if begins_here { None } else { fitting(END - TOP) };
        fitting(END - self.y).or_else(on_next_page).unwrap_or(1.0)
    }

    /// Returns the file, with page numbers.
    pub fn finish(mut self, title: &str, author: &str, language: &str, unix_time_s: u64) -> Vec<u8> {
        let pages = self.paper.pages();
        let how = Type { size: 8.0, bold: false, ink: SOFT, turn_deg: 0.0, rim: 0.0 };
        let named = drawable(title);
        for page in 0..pages {
            let number = format!("{} / {pages}", page + 1);
            let x = A4[0] - SIDE - text_width(&number, how.size, false);
            self.paper.set(page, &number, [x, A4[1] - 28.0], &how);
            if page > 0 {
                self.paper.set(page, &named, [SIDE, A4[1] - 28.0], &how);
            }
        }
        self.paper.finish(title, author, language, unix_time_s)
    }

    fn heading(&mut self, level: u8, runs: &[TextRun], company: f64) {
        let size = HEADINGS[usize::from(level.clamp(1, 3)) - 1];
        let lines = lines(&words(&bold(runs), size), WIDTH);
        let before = if self.y > TOP { 0.9 * size } else { 0.0 };
        let height = before + lines.len() as f64 * size * 1.25 + 0.35 * size;
        if self.y > TOP {
            self.need(height + company);
        }
        self.y += if self.y > TOP { before } else { 0.0 };
        for line in &lines {
            self.y += size * 1.25;
            self.line(line, SIDE, self.y - 0.3 * size);
        }
        self.y += 0.35 * size;
    }

    fn words(&mut self, runs: &[TextRun], size: f64, indent: f64) {
        for line in lines(&words(runs, size), WIDTH - indent) {
            let height = size * LINE;
            self.need(height);
            self.y += height;
            self.line(&line, SIDE + indent, self.y - 0.4 * size);
        }
        self.y += BELOW_WORDS * size;
    }

    fn item(&mut self, runs: &[TextRun]) {
        self.need(BODY * LINE);
        let how = Type { size: BODY, bold: false, ink: BLACK, turn_deg: 0.0, rim: 0.0 };
        self.paper.set(self.page, "·", [SIDE + 3.0, self.y + BODY * LINE - 0.4 * BODY], &how);
        self.words(runs, ITEM, ITEM_INDENT);
    }

    fn typed(&mut self, text: &str) {
        for line in text.lines() {
            self.words(&[TextRun { text: line.to_owned(), small: true, ..TextRun::default() }], BODY, 10.0);
        }
    }

    /// Draws lines for signatures, side by side.
    fn signatures(&mut self, lines: &[Vec<TextRun>]) {
        const ROOM: f64 = 44.0;
        self.need(ROOM + BODY * LINE);
        self.y += ROOM;
        let column = (WIDTH - GUTTER) / lines.len().max(1) as f64;
        for (place, runs) in lines.iter().enumerate() {
            let x = SIDE + place as f64 * (column + GUTTER);
            let rule = (vec![[x, self.y], [x + column - GUTTER, self.y]], false);
            self.paper.draw(
                self.page,
                &[rule],
                None,
                Some(PaperStroke { ink: SOFT, width: 0.7, opacity: 1.0, dash: None }),
            );
            self.line(&words(runs, SMALL * BODY), x, self.y + 1.1 * BODY);
        }
        self.y += BODY * LINE;
    }

    fn terms(&mut self, terms: &[(Vec<TextRun>, Vec<TextRun>)]) {
        let (left, rows) = terms_laid_out(terms);
        for [name, meaning] in &rows {
            let height = name.len().max(meaning.len()) as f64 * TABLE * LINE;
            self.need(height);
            for (lines, x) in [(name, SIDE), (meaning, SIDE + left)] {
                for (number, line) in lines.iter().enumerate() {
                    self.line(line, x, self.y + (number + 1) as f64 * TABLE * LINE - 0.4 * TABLE);
                }
            }
            self.y += height + 1.5;
        }
        self.y += 0.4 * TABLE;
    }

    fn table(&mut self, table: &PaperTable) {
        let (size, widths) = column_widths(table);
        self.y += 3.0;
        if !table.caption.is_empty() {
            self.need(COMPANY);
            self.words(&bold(&table.caption), size, 0.0);
        }
        let head = laid_out(&table.head, &widths, size);
        let head_height = row_lines(&head) * size * 1.3 + 4.0;
        let rows: Vec<(Vec<Vec<Vec<Word>>>, bool)> = table
            .rows
            .iter()
            .map(|(cells, is_total)| {
                let cells: Vec<TextCell> =
                    if *is_total { cells.iter().map(|cell| bold(cell)).collect() } else { cells.clone() };
                (laid_out(&cells, &widths, size), *is_total)
            })
            .collect();
        let height_of = |cells: &[Vec<Vec<Word>>]| row_lines(cells) * size * 1.34 + 4.0;
        self.need(head_height + rows.first().map_or(0.0, |(cells, _)| height_of(cells)));
        self.row(&head, table, &widths, size, true);
        for (cells, is_total) in &rows {
            if self.y + height_of(cells) > END && self.y > TOP {
                self.turn();
                self.row(&head, table, &widths, size, true);
            }
            if *is_total {
                self.rule(BLACK, 0.9);
            }
            self.row(cells, table, &widths, size, false);
        }
        self.y += 6.0;
    }

    fn row(&mut self, cells: &[Vec<Vec<Word>>], table: &PaperTable, widths: &[f64], size: f64, is_head: bool) {
        let height = row_lines(cells) * size * if is_head { 1.3 } else { 1.34 };
        let mut x = SIDE;
        for (column, lines) in cells.iter().enumerate() {
            let column_width = widths.get(column).copied().unwrap_or(0.0);
            let is_text = table.is_text.get(column).copied().unwrap_or(true);
            // Headings stand at the bottom of their row.
            let drop = if is_head { height - lines.len() as f64 * size * 1.3 } else { 0.0 };
            for (number, line) in lines.iter().enumerate() {
                let step = size * if is_head { 1.3 } else { 1.34 };
                let y = self.y + 2.0 + drop + (number + 1) as f64 * step - 0.34 * size;
                let begin = if is_text { x } else { x + column_width - width(line) };
                self.line(line, begin, y);
            }
            x += column_width + GAP;
        }
        self.y += height + 4.0;
        self.rule(if is_head { BLACK } else { FAINT }, if is_head { 0.9 } else { 0.6 });
    }

    fn rule(&mut self, ink: Ink, width: f64) {
        let line = (vec![[SIDE, self.y], [SIDE + WIDTH, self.y]], false);
        self.paper.draw(self.page, &[line], None, Some(PaperStroke { ink, width, opacity: 1.0, dash: None }));
    }

    fn figures(&mut self, figures: &[Figure], tall: bool, size: f64) {
        let is_alone = figures.len() == 1;
        for pair in figures.chunks(2) {
            self.need(ABOVE_FIGURES + row_height(pair, is_alone, tall, size));
            self.y += ABOVE_FIGURES;
            let (begin, mut end) = (self.y, self.y);
            for (place, figure) in pair.iter().enumerate() {
                let x = SIDE + place as f64 * (figure_column(is_alone) + GUTTER);
                end = end.max(self.figure(figure, [x, begin], is_alone, tall, size));
            }
            self.y = end + BELOW_FIGURES;
        }
    }

    /// Draws a figure from a corner on, and returns the y at which it ends.
    fn figure(&mut self, figure: &Figure, [x, top]: [f64; 2], is_alone: bool, tall: bool, size: f64) -> f64 {
        let (column, mut y) = (figure_column(is_alone), top);
        for line in lines(&words(&bold(&figure.title), HEADINGS[2]), column) {
            y += HEADINGS[2] * LINE;
            self.line(&line, x, y - 0.4 * HEADINGS[2]);
        }
        let scale = size * scale_of(figure, is_alone, tall);
        drawing::draw(&mut self.paper, self.page, figure.svg, [x, y], scale);
        y += drawing::size(figure.svg)[1] * scale + 2.0;
        for line in lines(&words(&figure.caption, SMALL * BODY), column) {
            y += SMALL * BODY * LINE;
            self.line(&line, x, y - 0.4 * BODY);
        }
        y
    }

    /// Sets a line of words. A verdict has a bar before it.
    fn line(&mut self, line: &[Word], x: f64, y: f64) {
        let mut at = x;
        for (index, word) in line.iter().enumerate() {
            at += if word.is_apart && index > 0 { space(word) } else { 0.0 };
            let run = &word.run;
            if !run.verdict.is_empty() && (index == 0 || line[index - 1].run.verdict.is_empty()) {
                let (left, high) = (at, y - 0.85 * word.size);
                let bar = vec![
                    [left, high],
                    [left + 2.4, high],
                    [left + 2.4, y + 0.25 * word.size],
                    [left, y + 0.25 * word.size],
                ];
                self.paper.draw(self.page, &[(bar, true)], Some((verdict_ink(run.verdict), 1.0)), None);
                at += VERDICT_BAR;
            }
            let ink = if run.soft { SOFT } else { BLACK };
            let drop = if run.low { 0.22 * word.size } else { 0.0 };
            let how = Type { size: word.size, bold: run.bold, ink, turn_deg: 0.0, rim: 0.0 };
            self.paper.set(self.page, &run.text, [at, y + drop], &how);
            at += word.width;
        }
    }
}

/// Width that a verdict's bar takes, in points.
const VERDICT_BAR: f64 = 6.0;

fn verdict_ink(verdict: &str) -> Ink {
    match verdict {
        "met" => [0, 122, 77],
        "not-met" => [213, 94, 0],
        "undecided" => [138, 138, 138],
        _ => BLUE,
    }
}

fn space(word: &Word) -> f64 {
    text_width(" ", word.size, word.run.bold)
}

/// The same text in bold.
fn bold(runs: &[TextRun]) -> Vec<TextRun> {
    runs.iter().map(|run| TextRun { bold: true, ..run.clone() }).collect()
}

/// Splits runs into words. A run that does not begin with a space continues the word before it.
fn words(runs: &[TextRun], size: f64) -> Vec<Word> {
    let mut found: Vec<Word> = Vec::new();
    let mut is_apart = false;
    for run in runs {
        let mut type_size = size;
        type_size *= if run.small { SMALL } else { 1.0 };
        type_size *= if run.low { LOW } else { 1.0 };
        if run.text == "\n" {
            found.push(Word { run: run.clone(), size: type_size, width: 0.0, is_apart: true });
            is_apart = false;
            continue;
        }
        let mut is_first = true;
        // A verdict is never broken over lines.
        let text = if run.verdict.is_empty() { run.text.clone() } else { run.text.replace(' ', "\u{a0}") };
        for piece in text.split(' ') {
            is_apart |= !is_first;
            is_first = false;
            if piece.is_empty() {
                continue;
            }
            let text = drawable(piece);
            let width = text_width(&text, type_size, run.bold);
            found.push(Word { run: TextRun { text, ..run.clone() }, size: type_size, width, is_apart });
            is_apart = false;
        }
    }
    found
}

/// Width of a line, to which words are added one by one.
#[derive(Clone, Copy, Default)]
struct LineWidth {
    count: usize,
    words: f64,
    spaces: f64,
    has_verdict: bool,
}

impl LineWidth {
    /// The width with these words added.
    fn with(self, words: &[Word]) -> LineWidth {
        words.iter().fold(self, |line, word| LineWidth {
            count: line.count + 1,
            words: line.words + word.width,
            spaces: line.spaces + if word.is_apart && line.count > 0 { space(word) } else { 0.0 },
            has_verdict: line.has_verdict || !word.run.verdict.is_empty(),
        })
    }

    fn all(&self) -> f64 {
        let bar = if self.has_verdict { VERDICT_BAR } else { 0.0 };
        bar + self.words + self.spaces
    }
}

/// Width of words on one line.
fn width(line: &[Word]) -> f64 {
    LineWidth::default().with(line).all()
}

/// Breaks words into lines no wider than a column. Words without a space between them stay together.
fn lines(words: &[Word], column: f64) -> Vec<Vec<Word>> {
    let mut found: Vec<Vec<Word>> = Vec::new();
    let (mut line, mut width) = (0..0, LineWidth::default());
    let mut index = 0;
    while index < words.len() {
        if words[index].run.text == "\n" {
            found.push(words[line].to_vec());
            index += 1;
            (line, width) = (index..index, LineWidth::default());
            continue;
        }
        let sticking = 1 + words[index + 1..].iter().take_while(|word| !word.is_apart).count();
        let piece = &words[index..index + sticking];
        let with = width.with(piece);
        if !line.is_empty() && with.all() > column + 0.01 {
            found.push(words[line].to_vec());
            (line, width) = (index..index, LineWidth::default().with(piece));
        } else {
            width = with;
        }
        index += sticking;
        line.end = index;
    }
    if !line.is_empty() {
        found.push(words[line].to_vec());
    }
    found
}

/// The left edge of the meanings, and the lines of each term and of its meaning.
fn terms_laid_out(terms: &[(Vec<TextRun>, Vec<TextRun>)]) -> (f64, Vec<[Vec<Vec<Word>>; 2]>) {
    let all = terms.iter().map(|(name, _)| width(&words(&bold(name), TABLE)));
    let left = all.fold(0.0, f64::max).min(0.3 * WIDTH) + GAP;
    let row = |(name, meaning): &(Vec<TextRun>, Vec<TextRun>)| {
        [lines(&words(&bold(name), TABLE), left - GAP), lines(&words(meaning, TABLE), WIDTH - left)]
    };
    (left, terms.iter().map(row).collect())
}

/// Height of terms and their meanings.
fn terms_height(terms: &[(Vec<TextRun>, Vec<TextRun>)]) -> f64 {
    let (_, rows) = terms_laid_out(terms);
    rows.iter().map(|[name, meaning]| name.len().max(meaning.len()) as f64 * TABLE * LINE + 1.5).sum()
}

fn laid_out(cells: &[TextCell], widths: &[f64], size: f64) -> Vec<Vec<Vec<Word>>> {
    let column = |index: usize| widths.get(index).copied().unwrap_or(0.0);
    cells.iter().enumerate().map(|(index, cell)| lines(&words(cell, size), column(index) + 0.01)).collect()
}

fn row_lines(cells: &[Vec<Vec<Word>>]) -> f64 {
    cells.iter().map(Vec::len).max().unwrap_or(0).max(1) as f64
}

/// Type size and column widths of a table. First the text columns are narrowed, then the type is reduced.
fn column_widths(table: &PaperTable) -> (f64, Vec<f64>) {
    let columns = table.head.len();
    let cells = |column: usize| {
        std::iter::once(&table.head[column]).chain(table.rows.iter().filter_map(move |(cells, _)| cells.get(column)))
    };
    let widest = |size: f64, column: usize, limit: f64| {
        let of_cell =
            |cell: &TextCell| lines(&words(cell, size), limit).iter().map(|line| width(line)).fold(0.0, f64::max);
        cells(column).map(of_cell).fold(0.0, f64::max)
    };
    let mut size = TABLE;
    loop {
        let room = WIDTH - GAP * columns.saturating_sub(1) as f64;
        let natural: Vec<f64> = (0..columns).map(|column| widest(size, column, f64::INFINITY)).collect();
        let least: Vec<f64> = (0..columns)
            .map(|column| if table.is_text[column] { widest(size, column, 0.0) } else { natural[column] })
            .collect();
        let (all, tight): (f64, f64) = (natural.iter().sum(), least.iter().sum());
        if all <= room {
            // Spare width goes to the text columns.
            let words = table.is_text.iter().filter(|is_text| **is_text).count().max(1) as f64;
            let spare = |column: usize| if table.is_text[column] { (room - all) / words } else { 0.0 };
            return (size, (0..columns).map(|column| natural[column] + spare(column)).collect());
        }
        if tight <= room || size <= LEAST_TYPE {
            let share = ((room - tight) / (all - tight).max(1e-9)).clamp(0.0, 1.0);
            return (
                size,
                natural.iter().zip(&least).map(|(natural, least)| least + share * (natural - least)).collect(),
            );
        }
        size -= 0.2;
    }
}

/// Available width for a picture alone, or for one of two side by side.
fn figure_column(is_alone: bool) -> f64 {
    if is_alone { WIDTH } else { 0.5 * (WIDTH - GUTTER) }
}

/// Largest scale of a picture that fits its limits.
fn scale_of(figure: &Figure, is_alone: bool, tall: bool) -> f64 {
    let [width, height] = drawing::size(figure.svg);
    let highest = match (tall, is_alone) {
        (true, _) => TALL,
        (false, true) => ALONE,
        (false, false) => BESIDE,
    };
    (figure_column(is_alone) / width).min(highest / height).min(POINTS)
}

/// Height of figures side by side, with their words.
fn row_height(row: &[Figure], is_alone: bool, tall: bool, size: f64) -> f64 {
    let column = figure_column(is_alone);
    let height = |figure: &Figure| {
        let title = lines(&words(&figure.title, HEADINGS[2]), column).len() as f64 * HEADINGS[2] * LINE;
        let caption = lines(&words(&figure.caption, SMALL * BODY), column).len() as f64 * SMALL * BODY * LINE;
        title + caption + drawing::size(figure.svg)[1] * size * scale_of(figure, is_alone, tall) + 2.0
    };
    row.iter().map(height).fold(0.0, f64::max)
}

/// Height of the first row of pictures at full size.
fn first_row_height(figures: &[Figure], tall: bool) -> f64 {
    figures.chunks(2).next().map_or(0.0, |row| row_height(row, figures.len() == 1, tall, 1.0))
}

/// Height of pictures, at a size, and of words up to the next heading. `None` if there are other blocks among them.
fn height_to_heading(blocks: &[PageBlock], size: f64) -> Option<f64> {
    let words_height = |runs: &[TextRun], type_size: f64, indent: f64| {
        (lines(&words(runs, type_size), WIDTH - indent).len() as f64 * LINE + BELOW_WORDS) * type_size
    };
    let section = blocks.iter().take_while(|block| !matches!(block, PageBlock::Heading(..)));
    let heights = section.map(|block| match block {
        PageBlock::Words(runs) => Some(words_height(runs, BODY, 0.0)),
        PageBlock::Item(runs) => Some(words_height(runs, ITEM, ITEM_INDENT)),
        PageBlock::Figures(figures, tall) => {
            let row = |row| ABOVE_FIGURES + row_height(row, figures.len() == 1, *tall, size) + BELOW_FIGURES;
            Some(figures.chunks(2).map(row).sum())
        }
        _ => None,
    });
    heights.sum()
}
