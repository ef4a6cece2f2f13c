//! The JSON Schema (draft 2020-12) of the scene file, from the tables of keys that the reader checks files by.

use serde_json::{Map, Value, json};

use super::file;
use super::keys::{Form, Key, NumberRange, ValueShape};

/// JSON Schema of the scene file.
pub fn scene_schema() -> Value {
    let mut definitions = Map::new();
    let mut schema = object(&file::FORM, &mut definitions);
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!(file::FORM.name);
    schema["$defs"] = Value::Object(definitions);
    schema
}

/// Schema of an object. The objects and kinds that it refers to are added to the definitions.
fn object(form: &Form, definitions: &mut Map<String, Value>) -> Value {
    let property = |key: &Key, definitions: &mut Map<String, Value>| {
        let schema = match key.shape {
            ValueShape::Type => json!({ "type": "string", "const": form.name }),
            shape => described(of_shape(shape, definitions), key.doc),
        };
        (key.name.to_owned(), schema)
    };
    let properties: Map<String, Value> = form.keys().map(|key| property(key, definitions)).collect();
    let required: Vec<&str> = form.keys().filter(|key| key.is_needed).map(|key| key.name).collect();
    let mut schema = json!({ "type": "object", "additionalProperties": false, "properties": properties });
    if !required.is_empty() {
        schema["required"] = json!(required);
    }
    if !form.either.is_empty() {
        schema["oneOf"] = form.either.iter().map(|keys| json!({ "required": keys })).collect();
    }
    described(schema, form.doc)
}

fn of_shape(shape: ValueShape, definitions: &mut Map<String, Value>) -> Value {
    match shape {
        ValueShape::Text | ValueShape::Type => json!({ "type": "string" }),
        ValueShape::Boolean => json!({ "type": "boolean" }),
        ValueShape::Choice(names) => json!({ "type": "string", "enum": names }),
        ValueShape::Number(span) => number(span),
        ValueShape::Count(u32::MAX) => json!({ "type": "integer", "format": "uint32", "minimum": 1 }),
        ValueShape::Count(most) => json!({ "type": "integer", "format": "uint32", "minimum": 1, "maximum": most }),
        ValueShape::Index => json!({ "type": "integer", "format": "uint32", "minimum": 0 }),
        ValueShape::Whole => json!({ "type": "integer", "format": "int32" }),
        ValueShape::Only(number) => json!({ "type": "integer", "format": "uint32", "minimum": 0, "const": number }),
        ValueShape::Vector => list(number(NumberRange::ANY), [3, 3]),
        ValueShape::List(item, lengths) => list(of_shape(*item, definitions), lengths),
        ValueShape::Tuple(items) => {
            let schemas: Vec<Value> = items.iter().map(|item| of_shape(*item, definitions)).collect();
            json!({ "type": "array", "prefixItems": schemas, "minItems": items.len(), "maxItems": items.len() })
        }
        ValueShape::AnyOf(choices) => {
            let schemas: Vec<Value> =
                choices.iter().map(|(doc, shape)| described(of_shape(*shape, definitions), doc)).collect();
            json!({ "anyOf": schemas })
        }
        ValueShape::Map(value) => json!({ "type": "object", "additionalProperties": of_shape(*value, definitions) }),
        ValueShape::Object(form) => defined(form.name, definitions, |definitions| object(form, definitions)),
        ValueShape::Kinds(kinds) => defined(kinds.name, definitions, |definitions| {
            let schemas: Vec<Value> = kinds.forms.iter().map(|form| object(form, definitions)).collect();
            described(json!({ "oneOf": schemas }), kinds.doc)
        }),
    }
}

/// Refers to a definition, and adds it if it is new.
fn defined(
    name: &str,
    definitions: &mut Map<String, Value>,
    schema: impl FnOnce(&mut Map<String, Value>) -> Value,
) -> Value {
    if !definitions.contains_key(name) {
        let schema = schema(definitions);
        definitions.insert(name.to_owned(), schema);
    }
    json!({ "$ref": format!("#/$defs/{name}") })
}

fn number(NumberRange { least, is_open, most }: NumberRange) -> Value {
    let mut schema = json!({ "type": "number", "format": "double" });
    if least.is_finite() {
        schema[if is_open { "exclusiveMinimum" } else { "minimum" }] = json!(least);
    }
    if most.is_finite() {
        schema["maximum"] = json!(most);
    }
    schema
}

fn list(items: Value, [least, most]: [usize; 2]) -> Value {
    let mut schema = json!({ "type": "array", "items": items });
    if least > 0 {
        schema["minItems"] = json!(least);
    }
    if most < usize::MAX {
        schema["maxItems"] = json!(most);
    }
    schema
}

fn described(mut schema: Value, doc: &str) -> Value {
    schema["description"] = json!(doc);
    schema
}
