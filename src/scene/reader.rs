//! Reads the syntax tree of a scene file value by value, so that every refusal has its exact position.

use std::ops::Range;
use std::path::Path;
use std::rc::Rc;

use glam::DVec3;
use jsonc_parser::ast::{ObjectProp, Value};
use jsonc_parser::common::Ranged;

use super::error::{Refusal, SceneError, TextPlace};
use super::keys::{Form, Key, NumberRange, ObjectKinds, ValueShape};
use super::names::{listed, nearest};

/// A text and its name in messages.
pub(crate) struct Source<'t> {
    pub text: &'t str,
    pub path: &'t Path,
}

impl Source<'_> {
    /// Makes a refusal at a byte range of the text.
    pub fn refuse(
        &self,
        range: Range<usize>,
        json_path: &str,
        what: impl Into<String>,
        got: impl Into<String>,
        expected: impl Into<String>,
        remedy: impl Into<String>,
    ) -> SceneError {
        SceneError::new(Refusal {
            path: self.path.to_path_buf(),
            place: Some(TextPlace::of(self.text, range.start, range.end, json_path)),
            named_by: None,
            what: what.into(),
            got: got.into(),
            expected: expected.into(),
            remedy: remedy.into(),
        })
    }
}

/// A value of the file and its path there.
#[derive(Clone)]
pub(crate) struct Node<'a> {
    source: &'a Source<'a>,
    value: &'a Value<'a>,
    way: ValuePath<'a>,
    /// What the table of the object's keys says of it; `None` where there is no table.
    shape: Option<&'static ValueShape>,
}

/// The keys and indices that lead to a value. They become text only for messages, because most files have no error.
#[derive(Clone, Default)]
struct ValuePath<'a>(Option<Rc<PathStep<'a>>>);

struct PathStep<'a> {
    before: ValuePath<'a>,
    last: Last<'a>,
}

enum Last<'a> {
    Key(&'a str),
    Place(usize),
}

impl<'a> ValuePath<'a> {
    fn to(&self, last: Last<'a>) -> ValuePath<'a> {
        ValuePath(Some(Rc::new(PathStep { before: self.clone(), last })))
    }

    fn text(&self) -> String {
        let Some(step) = &self.0 else { return String::new() };
        let before = step.before.text();
        match step.last {
            Last::Key(key) => child(&before, key),
            Last::Place(place) => format!("{before}[{place}]"),
        }
    }
}

/// The keys of an object. No key appears twice.
#[derive(Clone)]
pub(crate) struct Fields<'a> {
    node: Node<'a>,
    what: String,
    properties: &'a [ObjectProp<'a>],
    /// The table of its keys; `None` for names that the file chooses, and before the object's kind is known.
    form: Option<Form>,
}

/// One key of an object and its value.
pub(super) struct Entry<'a> {
    pub name: &'a str,
    pub value: Node<'a>,
    /// Byte range of the key.
    pub key_range: Range<usize>,
}

impl<'a> Node<'a> {
    /// Returns the topmost value of a text.
    pub fn root(source: &'a Source<'a>, value: &'a Value<'a>) -> Node<'a> {
        Node { source, value, way: ValuePath::default(), shape: None }
    }

    /// Returns the path of the value, such as `geometry[0].min`.
    pub fn json_path(&self) -> String {
        self.way.text()
    }

    /// Returns `scene.json, line 3, column 9, at geometry[0].file`, for refusals of files that the scene names.
    pub fn as_namer(&self) -> String {
        let start = self.value.range().start;
        let TextPlace { line, column, .. } = TextPlace::of(self.source.text, start, start, "");
        format!("{}, line {line}, column {column}, at {}", self.source.path.display(), self.json_path())
    }

    /// Refuses the value; the message shows it as it is in the file.
    pub fn refuse(
        &self,
        what: impl Into<String>,
        expected: impl Into<String>,
        remedy: impl Into<String>,
    ) -> SceneError {
        self.refuse_as(what, self.described(), expected, remedy)
    }

    /// Refuses the value; `got` describes it in the message.
    pub fn refuse_as(
        &self,
        what: impl Into<String>,
        got: impl Into<String>,
        expected: impl Into<String>,
        remedy: impl Into<String>,
    ) -> SceneError {
        let range = self.value.range();
        self.source.refuse(range.start..range.end, &self.json_path(), what, got, expected, remedy)
    }

    fn refuse_type(&self, expected: &str, remedy: &str) -> SceneError {
        let path = self.json_path();
        let name = if path.is_empty() { "the file".to_string() } else { format!("\"{path}\"") };
        self.refuse(format!("{name} has the wrong type"), expected, remedy)
    }

    fn described(&self) -> String {
        match self.value {
            Value::StringLit(text) => format!("the text {:?}", shortened(&text.value)),
            Value::NumberLit(number) => format!("the number {}", shortened(number.value)),
            Value::BooleanLit(boolean) => boolean.value.to_string(),
            Value::NullKeyword(_) => "null".into(),
            Value::Array(array) if array.elements.is_empty() => "an empty list".into(),
            Value::Array(array) => format!("a list of {}", array.elements.len()),
            Value::Object(object) if object.properties.is_empty() => "an empty object".into(),
            Value::Object(object) => {
                format!("an object with {}", listed(object.properties.iter().map(|property| property.name.as_str())))
            }
        }
    }

    /// Returns the keys of an object, none of which is unknown. `what` names the object in messages (`a diffuse material`).
    pub(super) fn object(&self, what: &str, form: &Form) -> Result<Fields<'a>, SceneError> {
        self.fields(what)?.of(form)
    }

    /// Returns the keys of an object, whatever they are. `what` names the object in messages.
    pub fn fields(&self, what: &str) -> Result<Fields<'a>, SceneError> {
        let Value::Object(object) = self.value else {
            return Err(self.refuse_type(&format!("an object: {what}"), "write { \"key\": value, … }"));
        };
        let fields = Fields { node: self.clone(), what: what.into(), properties: &object.properties, form: None };
        let mut seen = std::collections::HashMap::new();
        for (property, name) in object.properties.iter().map(|property| (property, property.name.as_str())) {
            if let Some(first_start) = seen.insert(name, property.name.range().start) {
                let entry = fields.entry(property);
                let first = TextPlace::of(self.source.text, first_start, first_start, "");
                return Err(self.source.refuse(
                    entry.key_range.clone(),
                    &entry.value.json_path(),
                    format!("the key {:?} is given twice", shortened(entry.name)),
                    format!(
                        "{:?} again; it is already in line {}, column {}",
                        shortened(entry.name),
                        first.line,
                        first.column
                    ),
                    "each key once",
                    "delete or rename one of the two",
                ));
            }
        }
        Ok(fields)
    }

    /// Returns the values of a list.
    pub fn items(&self, what: &str) -> Result<Vec<Node<'a>>, SceneError> {
        let Value::Array(array) = self.value else {
            return Err(self.refuse_type(&format!("a list of {what}"), "write [ …, … ]"));
        };
        Ok(array
            .elements
            .iter()
            .enumerate()
            .map(|(index, value)| Node {
                source: self.source,
                value,
                way: self.way.to(Last::Place(index)),
                shape: None,
            })
            .collect())
    }

    /// Returns a text, which may be empty.
    pub fn text(&self) -> Result<&'a str, SceneError> {
        let Value::StringLit(text) = self.value else {
            return Err(self.refuse_type("a text in double quotes", "write \"…\""));
        };
        Ok(&text.value)
    }

    /// Returns a text that is not blank.
    pub fn name(&self) -> Result<&'a str, SceneError> {
        let name = self.text()?;
        if name.trim().is_empty() {
            return Err(self.refuse("an empty name", "a name with at least one letter", "give it a name"));
        }
        Ok(name)
    }

    /// Returns the index of a text among the key's choices.
    pub fn choice(&self) -> Result<usize, SceneError> {
        let Some(ValueShape::Choice(names)) = self.shape else { unreachable!("{} is no choice", self.json_path()) };
        self.choice_of(names)
    }

    /// Returns the index of a text in a list of allowed texts.
    pub fn choice_of(&self, allowed: &[&str]) -> Result<usize, SceneError> {
        let text = self.text()?;
        allowed.iter().position(|name| *name == text).ok_or_else(|| self.refuse_choice(text, allowed))
    }

    fn refuse_choice(&self, text: &str, allowed: &[&str]) -> SceneError {
        self.refuse(
            format!("{:?} is not an allowed value of \"{}\"", shortened(text), self.json_path()),
            listed(allowed.iter().copied()),
            meant(text, allowed.iter().copied()),
        )
    }

    /// Returns `true` or `false`.
    pub fn boolean(&self) -> Result<bool, SceneError> {
        let Value::BooleanLit(boolean) = self.value else {
            return Err(self.refuse_type("true or false", "write true or false, without quotes"));
        };
        Ok(boolean.value)
    }

    /// Whether the value is a text.
    pub fn is_text(&self) -> bool {
        matches!(self.value, Value::StringLit(_))
    }

    /// Returns a finite number.
    pub fn number(&self) -> Result<f64, SceneError> {
        let Value::NumberLit(number) = self.value else {
            return Err(self.refuse_type("a number", "write the number without quotes, brackets or a unit"));
        };
        match number.value.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(self.refuse(
                "a number that is not finite",
                "a number between -1.79e308 and 1.79e308",
                "write a number that a 64-bit float can hold",
            )),
        }
    }

    /// The range of the key's numbers.
    pub(super) fn range(&self) -> NumberRange {
        let Some(ValueShape::Number(span)) = self.shape else { unreachable!("{} is no number", self.json_path()) };
        *span
    }

    /// Returns a number in the key's range, which begins at 0. A greatest number other than 1 is the caller's to check.
    pub fn amount(&self, quantity: &str) -> Result<f64, SceneError> {
        let NumberRange { is_open, most, .. } = self.range();
        if is_open {
            self.above_zero(quantity)?;
        }
        if most == 1.0 { self.fraction(quantity) } else { self.at_least_zero(quantity) }
    }

    /// Returns a number of at least 0.
    pub fn at_least_zero(&self, quantity: &str) -> Result<f64, SceneError> {
        let value = self.number()?;
        if value < 0.0 {
            return Err(self.refuse(format!("{quantity} is negative"), "a number of at least 0", "remove the sign"));
        }
        Ok(value)
    }

    /// Returns a number above 0.
    pub fn above_zero(&self, quantity: &str) -> Result<f64, SceneError> {
        let value = self.number()?;
        if value <= 0.0 {
            let how = if value < 0.0 { "negative" } else { "0" };
            return Err(self.refuse(format!("{quantity} is {how}"), "a number above 0", "give a positive number"));
        }
        Ok(value)
    }

    /// Returns a number from 0 to 1.
    fn fraction(&self, quantity: &str) -> Result<f64, SceneError> {
        /// From this value on, a number is probably in percent rather than a typing error.
        const PERCENT_FROM: f64 = 2.0;
        let value = self.number()?;
        if value < 0.0 {
            return Err(self.refuse(format!("{quantity} is negative"), "a number from 0 to 1", "remove the sign"));
        }
        if value > 1.0 {
            let remedy = if (PERCENT_FROM..=100.0).contains(&value) {
                format!("if {value} % is meant, write {}", value / 100.0)
            } else {
                "give a number from 0 to 1".into()
            };
            return Err(self.refuse(format!("{quantity} is above 1"), "a number from 0 to 1", remedy));
        }
        Ok(value)
    }

    /// Returns a whole number of at least 1.
    pub fn count(&self, quantity: &str) -> Result<u32, SceneError> {
        let value = self.number()?;
        if value < 1.0 || value.fract() != 0.0 || value > f64::from(u32::MAX) {
            let expected = format!("a whole number from 1 to {}", u32::MAX);
            return Err(self.refuse(
                format!("{quantity} is not a count"),
                expected,
                "give a whole number of at least 1",
            ));
        }
        Ok(value as u32)
    }

    /// Returns three finite numbers.
    pub fn vector(&self) -> Result<DVec3, SceneError> {
        let expected = "a list of three numbers: [x, y, z]";
        let Value::Array(array) = self.value else {
            return Err(self.refuse_type(expected, "write [x, y, z]"));
        };
        if array.elements.len() != 3 {
            let what = format!("\"{}\" has {} numbers", self.json_path(), array.elements.len());
            return Err(self.refuse(what, expected, "give x, y and z"));
        }
        let numbers = self.items("numbers")?.iter().map(Node::number).collect::<Result<Vec<f64>, _>>()?;
        Ok(DVec3::new(numbers[0], numbers[1], numbers[2]))
    }

    /// Returns a unit vector from three numbers, which must not all be 0.
    pub fn direction(&self) -> Result<DVec3, SceneError> {
        let vector = self.vector()?;
        // First scaled by the largest component, so that the length of tiny or huge vectors does not underflow or overflow.
        let largest = vector.abs().max_element();
        if largest == 0.0 {
            let what = format!("\"{}\" has no direction", self.json_path());
            return Err(self.refuse_as(
                what,
                "a vector of length 0",
                "a vector of any other length",
                "give a direction",
            ));
        }
        Ok((vector / largest).normalize())
    }
}

impl<'a> Fields<'a> {
    /// The object itself.
    pub fn node(&self) -> &Node<'a> {
        &self.node
    }

    /// Returns all keys in the order of the file.
    pub(super) fn entries(&self) -> impl Iterator<Item = Entry<'a>> + '_ {
        self.properties.iter().map(|property| self.entry(property))
    }

    fn entry(&self, property: &'a ObjectProp<'a>) -> Entry<'a> {
        let range = property.name.range();
        let way = self.node.way.to(Last::Key(property.name.as_str()));
        Entry {
            name: property.name.as_str(),
            value: Node { source: self.node.source, value: &property.value, way, shape: None },
            key_range: range.start..range.end,
        }
    }

    /// Gives the object the table of its keys, and refuses those that are not in it.
    pub(super) fn of(self, form: &Form) -> Result<Fields<'a>, SceneError> {
        for property in self.properties {
            if !form.names().any(|name| name == property.name.as_str()) {
                let entry = self.entry(property);
                return Err(self.refuse_key(
                    &entry,
                    format!("{} has no key {:?}", self.what, shortened(entry.name)),
                    listed(form.names()),
                    meant(entry.name, form.names()),
                ));
            }
        }
        Ok(Fields { form: Some(*form), ..self })
    }

    /// Returns the number of the object's kind in the list of forms. A kind with two forms counts as the first.
    pub(super) fn kind(&self, kinds: &ObjectKinds) -> Result<usize, SceneError> {
        let node = self.need_as("type", &format!("\"{}\"", kinds.forms[0].name))?;
        let name = node.text()?;
        kinds.forms.iter().position(|form| form.name == name).ok_or_else(|| node.refuse_choice(name, &kinds.names()))
    }

    /// Refuses a key rather than its value.
    pub(super) fn refuse_key(&self, entry: &Entry, what: String, expected: String, remedy: String) -> SceneError {
        let got = format!("the key {:?}", shortened(entry.name));
        self.node.source.refuse(entry.key_range.clone(), &entry.value.json_path(), what, got, expected, remedy)
    }

    /// What the object's table says of a key.
    fn key(&self, name: &str) -> Option<&'static Key> {
        self.form.and_then(|form| form.keys().find(|key| key.name == name))
    }

    /// Returns the value of a key, if it is given.
    pub fn get(&self, key: &str) -> Option<Node<'a>> {
        let property = self.properties.iter().find(|property| property.name.as_str() == key)?;
        Some(Node { shape: self.key(key).map(|key| &key.shape), ..self.entry(property).value })
    }

    /// Returns the value of a key that must be given. The refusal proposes the table's example.
    pub fn need(&self, key: &str) -> Result<Node<'a>, SceneError> {
        self.need_as(key, self.key(key).map_or("…", |key| key.example))
    }

    /// Returns the value of a key that must be given. The refusal proposes an example.
    pub fn need_as(&self, key: &str, example: &str) -> Result<Node<'a>, SceneError> {
        self.get(key).ok_or_else(|| {
            self.node.refuse(
                format!("{} needs the key \"{key}\"", self.what),
                format!("\"{key}\" among its keys"),
                format!("add \"{key}\": {example}"),
            )
        })
    }

    /// Returns the index (0 or 1) and value of the one key that is given, of two keys for the same quantity.
    pub fn one_of(&self, keys: [&str; 2]) -> Result<(usize, Node<'a>), SceneError> {
        let expected = format!("either \"{}\" or \"{}\"", keys[0], keys[1]);
        match keys.map(|key| self.get(key)) {
            [Some(first), None] => Ok((0, first)),
            [None, Some(second)] => Ok((1, second)),
            [Some(_), Some(second)] => Err(second.refuse_as(
                format!("{} has both \"{}\" and \"{}\"", self.what, keys[0], keys[1]),
                "both",
                expected,
                "delete one of them",
            )),
            [None, None] => Err(self.node.refuse(
                format!("{} needs \"{}\" or \"{}\"", self.what, keys[0], keys[1]),
                expected,
                format!("add \"{}\": a number", keys[0]),
            )),
        }
    }
}

/// Returns a remedy for a mistyped name: the allowed name that it may mean.
pub(super) fn meant<'a>(typed: &str, allowed: impl IntoIterator<Item = &'a str>) -> String {
    match nearest(typed, allowed) {
        Some(name) => format!("perhaps \"{name}\" is meant"),
        None => "use one of those, or delete it".into(),
    }
}

/// Shortens a text for a message.
pub(super) fn shortened(text: &str) -> String {
    /// Most characters of a value that a message repeats.
    const MOST_LETTERS: usize = 60;
    if text.chars().count() <= MOST_LETTERS {
        return text.to_string();
    }
    format!("{}…", text.chars().take(MOST_LETTERS).collect::<String>())
}

fn child(parent: &str, key: &str) -> String {
    let plain = key.chars().all(|character| character.is_alphanumeric() || "_-".contains(character));
    match (plain && !key.is_empty(), parent.is_empty()) {
        (true, true) => key.to_string(),
        (true, false) => format!("{parent}.{key}"),
        (false, _) => format!("{parent}[{key:?}]"),
    }
}
