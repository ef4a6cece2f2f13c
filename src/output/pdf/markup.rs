//! Parses the report's own markup into blocks for the layout on paper. The markup is well-formed and has no other elements than
//! these.

use roxmltree::Node;

/// A piece of text in one style.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TextRun {
    /// The text; `\n` ends a line.
    pub text: String,
    /// Bold.
    pub bold: bool,
    /// Smaller.
    pub small: bool,
    /// In soft ink.
    pub soft: bool,
    /// A subscript.
    pub low: bool,
    /// The verdict in this text: `met`, `not-met` or `undecided`; else empty.
    pub verdict: &'static str,
}

/// A cell of a table.
pub type TextCell = Vec<TextRun>;

/// A table.
#[derive(Clone, Debug, Default)]
pub struct PaperTable {
    /// Words above it.
    pub caption: Vec<TextRun>,
    /// Headings, which are repeated on every page.
    pub head: Vec<TextCell>,
    /// Whether each column holds words, flush left.
    pub is_text: Vec<bool>,
    /// Rows, and whether each is a row of totals.
    pub rows: Vec<(Vec<TextCell>, bool)>,
}

/// A picture with the words above and below it.
#[derive(Clone, Debug)]
pub struct Figure<'a, 'b> {
    /// Words above it.
    pub title: Vec<TextRun>,
    /// The `svg` element.
    pub svg: Node<'a, 'b>,
    /// Words below it.
    pub caption: Vec<TextRun>,
}

/// A block that takes the full width of a page.
#[derive(Clone, Debug)]
pub enum PageBlock<'a, 'b> {
    /// A heading of a level, and whether it begins a page.
    Heading(u8, Vec<TextRun>, bool),
    /// A paragraph.
    Words(Vec<TextRun>),
    /// An item of a list.
    Item(Vec<TextRun>),
    /// Preformatted text.
    Typed(String),
    /// Terms and their meanings.
    Terms(Vec<(Vec<TextRun>, Vec<TextRun>)>),
    /// Lines for signatures, with the words below each.
    Signatures(Vec<Vec<TextRun>>),
    /// A table.
    Table(PaperTable),
    /// Pictures side by side, at most two in a row. The flag permits heights up to a full page.
    Figures(Vec<Figure<'a, 'b>>, bool),
}

/// The blocks of an element, in order.
pub fn blocks<'a, 'b>(element: Node<'a, 'b>) -> Vec<PageBlock<'a, 'b>> {
    let mut found = Vec::new();
    for child in element.children().filter(Node::is_element) {
        let class = child.attribute("class").unwrap_or_default();
        match (child.tag_name().name(), class) {
            ("h1", _) => found.push(PageBlock::Heading(1, runs(child), false)),
            ("h2", class) => found.push(PageBlock::Heading(2, runs(child), class == "page")),
            ("h3", _) => found.push(PageBlock::Heading(3, runs(child), false)),
            ("p" | "footer", _) => found.push(PageBlock::Words(runs(child))),
            ("li", _) => found.push(PageBlock::Item(runs(child))),
            ("pre", _) => found.push(PageBlock::Typed(text(child))),
            ("dl", _) => found.push(PageBlock::Terms(terms(child))),
            ("table", _) => found.push(PageBlock::Table(table(child))),
            ("figure", _) => found.extend(figure(child).map(|figure| PageBlock::Figures(vec![figure], false))),
            ("div", "tall") => {
                found.extend(of_name(child, "figure").filter_map(figure).map(|one| PageBlock::Figures(vec![one], true)))
            }
            ("div", "signatures") => found.push(PageBlock::Signatures(of_name(child, "p").map(runs).collect())),
            ("div", "row" | "pair") => {
                found.push(PageBlock::Figures(of_name(child, "figure").filter_map(figure).collect(), false))
            }
            ("div" | "header" | "ul", _) => found.extend(blocks(child)),
            _ => {}
        }
    }
    found
}

fn of_name<'a, 'b>(element: Node<'a, 'b>, name: &'static str) -> impl Iterator<Item = Node<'a, 'b>> {
    element.descendants().filter(move |node| node.tag_name().name() == name)
}

fn figure<'a, 'b>(element: Node<'a, 'b>) -> Option<Figure<'a, 'b>> {
    let heading = element.prev_sibling_element().filter(|before| before.tag_name().name() == "h3");
    let is_in_pair = element.ancestors().any(|node| node.attribute("class") == Some("pair"));
    Some(Figure {
        title: heading.filter(|_| is_in_pair).map(runs).unwrap_or_default(),
        svg: of_name(element, "svg").next()?,
        caption: of_name(element, "figcaption").next().map(runs).unwrap_or_default(),
    })
}

fn terms(list: Node) -> Vec<(Vec<TextRun>, Vec<TextRun>)> {
    let meanings = of_name(list, "dd");
    of_name(list, "dt").zip(meanings).map(|(term, meaning)| (runs(term), runs(meaning))).collect()
}

fn table(element: Node) -> PaperTable {
    let mut table = PaperTable {
        caption: of_name(element, "caption").next().map(runs).unwrap_or_default(),
        ..PaperTable::default()
    };
    for heading in of_name(element, "th") {
        table.is_text.push(heading.attribute("class") == Some("text"));
        table.head.push(heading_runs(heading));
    }
    for row in of_name(element, "tr") {
        let cells: Vec<TextCell> = of_name(row, "td").map(runs).collect();
        if !cells.is_empty() {
            table.rows.push((cells, row.attribute("class") == Some("total")));
        }
    }
    table
}

/// Small words of a heading get a line of their own.
fn heading_runs(heading: Node) -> Vec<TextRun> {
    let mut found = Vec::new();
    for mut run in runs(heading) {
        if run.small && !run.low && found.last().is_some_and(|before: &TextRun| !before.small && before.text != "\n") {
            found.push(TextRun { text: "\n".to_owned(), ..TextRun::default() });
        }
        run.bold = !run.small;
        run.soft = run.small;
        found.push(run);
    }
    found
}

/// All text of an element.
fn text(element: Node) -> String {
    element.descendants().filter(|node| node.is_text()).filter_map(|node| node.text()).collect()
}

/// The text of an element, split by style.
pub fn runs(element: Node) -> Vec<TextRun> {
    let class = element.attribute("class").unwrap_or_default();
    let look = TextRun {
        soft: class.contains("soft") || class == "kicker" || element.tag_name().name() == "figcaption",
        small: class.contains("small") || class == "kicker",
        ..TextRun::default()
    };
    let mut found = Vec::new();
    gather(element, &look, &mut found);
    found
}

fn gather(element: Node, look: &TextRun, found: &mut Vec<TextRun>) {
    for child in element.children() {
        if let Some(text) = child.text().filter(|_| child.is_text()) {
            let text = text.replace('\n', " ");
            found.push(TextRun { text, ..look.clone() });
            continue;
        }
        let class = child.attribute("class").unwrap_or_default();
        let mut inner = look.clone();
        match child.tag_name().name() {
            "b" => inner.bold = true,
            "small" => {
                inner.small = true;
                // On the page in the browser they have a line of their own.
                if element.tag_name().name() == "dd" {
                    found.push(TextRun { text: " ".to_owned(), ..look.clone() });
                }
            }
            "sub" => inner.low = true,
            "br" => found.push(TextRun { text: "\n".to_owned(), ..TextRun::default() }),
            _ => {}
        }
        inner.soft |= class.contains("soft") || class == "pm";
        if let Some(verdict) = class.strip_prefix("verdict ") {
            inner.bold = true;
            inner.verdict = ["met", "not-met", "undecided"].into_iter().find(|name| *name == verdict).unwrap_or("");
        }
        gather(child, &inner, found);
    }
}
