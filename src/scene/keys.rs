//! How the objects of the scene file are described: their keys, each with its shape, its range and a document. Every object has one table of
//! keys, beside the code that reads it. The reader refuses unknown keys and checks values by it; `schema.rs` makes the JSON Schema of it.

/// A key of an object.
#[derive(Clone, Copy)]
pub(super) struct Key {
    pub name: &'static str,
    pub shape: ValueShape,
    pub is_needed: bool,
    /// The value that a refusal proposes if the key is missing.
    pub example: &'static str,
    pub doc: &'static str,
}

/// What a value must be.
#[derive(Clone, Copy)]
pub(super) enum ValueShape {
    Text,
    Boolean,
    /// The name of the object's own kind.
    Type,
    /// One of some texts.
    Choice(&'static [&'static str]),
    Number(NumberRange),
    /// A whole number from 1 to a greatest one.
    Count(u32),
    /// A whole number from 0.
    Index,
    /// A whole number of any sign.
    Whole,
    /// This number alone.
    Only(u32),
    /// Three numbers.
    Vector,
    /// A list of at least and at most some values of one shape.
    List(&'static ValueShape, [usize; 2]),
    /// A list of one value of each shape.
    Tuple(&'static [ValueShape]),
    /// A value of one of some shapes, each with a document.
    AnyOf(&'static [(&'static str, ValueShape)]),
    Object(&'static Form),
    /// Values of one shape by names that the file chooses.
    Map(&'static ValueShape),
    /// An object of one of several kinds.
    Kinds(&'static ObjectKinds),
}

/// The numbers that a key accepts.
#[derive(Clone, Copy)]
pub(super) struct NumberRange {
    pub least: f64,
    /// Whether the least number itself is excluded.
    pub is_open: bool,
    pub most: f64,
}

impl NumberRange {
    /// All numbers.
    pub const ANY: NumberRange = NumberRange { least: f64::NEG_INFINITY, is_open: false, most: f64::INFINITY };
}

pub(super) const TEXT: ValueShape = ValueShape::Text;
pub(super) const BOOLEAN: ValueShape = ValueShape::Boolean;
pub(super) const VECTOR: ValueShape = ValueShape::Vector;
/// Any number, numbers of at least 0, above 0, from 0 to 1, and above 0 to 1.
pub(super) const NUMBER: ValueShape = ValueShape::Number(NumberRange::ANY);
pub(super) const FROM_ZERO: ValueShape = from_to(0.0, f64::INFINITY);
pub(super) const ABOVE_ZERO: ValueShape =
    ValueShape::Number(NumberRange { least: 0.0, is_open: true, most: f64::INFINITY });
pub(super) const SHARE: ValueShape = from_to(0.0, 1.0);
pub(super) const SHARE_ABOVE_ZERO: ValueShape =
    ValueShape::Number(NumberRange { least: 0.0, is_open: true, most: 1.0 });
/// A count without a limit of its own.
pub(super) const COUNT: ValueShape = ValueShape::Count(u32::MAX);
/// Lengths of lists.
pub(super) const ANY_LENGTH: [usize; 2] = [0, usize::MAX];
pub(super) const NOT_EMPTY: [usize; 2] = [1, usize::MAX];

/// The key of the kind, in every object that has one.
pub(super) const TYPE: Key = needed("type", ValueShape::Type, "", "");

/// Numbers between two limits, which are included.
pub(super) const fn from_to(least: f64, most: f64) -> ValueShape {
    ValueShape::Number(NumberRange { least, is_open: false, most })
}

/// A key that must be given.
pub(super) const fn needed(name: &'static str, shape: ValueShape, example: &'static str, doc: &'static str) -> Key {
    Key { name, shape, is_needed: true, example, doc }
}

/// A key that may be left out.
pub(super) const fn optional(name: &'static str, shape: ValueShape, doc: &'static str) -> Key {
    Key { name, shape, is_needed: false, example: "…", doc }
}

impl Key {
    /// The same key with an example, for a key that only other keys make necessary.
    pub const fn such_as(self, example: &'static str) -> Key {
        Key { example, ..self }
    }
}

/// An object of the file. Objects of one kind have the kind's name. In tables of keys, a key has one line, two if its document is long.
#[derive(Clone, Copy)]
pub(super) struct Form {
    pub name: &'static str,
    pub doc: &'static str,
    /// Its keys in groups, since several objects share some. Refusals list them in this order.
    pub groups: &'static [&'static [Key]],
    /// Keys of which exactly one set must be given; empty if there is no such choice.
    pub either: &'static [&'static [&'static str]],
}

/// Describes an object.
pub(super) const fn form(name: &'static str, doc: &'static str, groups: &'static [&'static [Key]]) -> Form {
    Form { name, doc, groups, either: &[] }
}

impl Form {
    /// The same object with a choice between sets of keys.
    pub const fn either(self, either: &'static [&'static [&'static str]]) -> Form {
        Form { either, ..self }
    }

    /// All keys.
    pub fn keys(&self) -> impl Iterator<Item = &'static Key> {
        self.groups.iter().copied().flatten()
    }

    /// Names of all keys.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.keys().map(|key| key.name)
    }
}

/// Objects of several kinds that the key `type` tells apart.
#[derive(Clone, Copy)]
pub(super) struct ObjectKinds {
    pub name: &'static str,
    pub doc: &'static str,
    /// The object of each kind. A kind with two forms stands twice, one after the other.
    pub forms: &'static [Form],
}

impl ObjectKinds {
    /// Names of the kinds, each once.
    pub fn names(&self) -> Vec<&'static str> {
        let mut names: Vec<&str> = self.forms.iter().map(|form| form.name).collect();
        names.dedup();
        names
    }
}

/// A kind of object: its name and keys, and how it is read.
pub(super) struct ObjectKind<R> {
    pub form: Form,
    pub read: R,
}

/// The forms of some kinds.
pub(super) const fn forms_of<R, const N: usize>(kinds: &[ObjectKind<R>; N]) -> [Form; N] {
    let mut forms = [kinds[0].form; N];
    let mut number = 1;
    while number < N {
        forms[number] = kinds[number].form;
        number += 1;
    }
    forms
}
