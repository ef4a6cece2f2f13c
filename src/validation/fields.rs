//! Reading of case files: texts, percentages, and numbers that runs fill in.

use std::path::Path;

use serde::de::{Deserialize, Deserializer, Error};
use serde_json::{Map, Value};

use super::error::CaseError;

/// Reads the text of a file. `what` describes the error if it cannot be read.
///
/// # Errors
///
/// A file that is missing or is not text.
pub(super) fn read_text(path: &Path, what: &str) -> Result<String, CaseError> {
    std::fs::read_to_string(path).map_err(|error| {
        let remedy = "check the name and the right to read it";
        CaseError::new(path, what, error.to_string(), "a text file", remedy)
    })
}

/// A fraction, written as `0.003` or as `"0.3%"`.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Fraction(pub f64);

impl<'de> Deserialize<'de> for Fraction {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Fraction, D::Error> {
        let value = Value::deserialize(deserializer)?;
        let read = match &value {
            Value::Number(number) => number.as_f64(),
            Value::String(text) => text
                .trim()
                .strip_suffix('%')
                .and_then(|digits| digits.trim().parse::<f64>().ok())
                .map(|percent| percent / 100.0),
            _ => None,
        };
        read.filter(|fraction| *fraction > 0.0 && *fraction < 1.0).map(Fraction).ok_or_else(|| {
            D::Error::custom(format!("{value} is not a fraction between 0 and 1, such as 0.003 or \"0.3%\""))
        })
    }
}

/// Replaces every text `"$name"` in a value by what the run gives for that name.
///
/// # Errors
///
/// The name that the run does not give.
pub(super) fn fill_in(value: &Value, given: &Map<String, Value>) -> Result<Value, String> {
    Ok(match value {
        Value::String(text) if text.starts_with('$') => {
            given.get(&text[1..]).cloned().ok_or_else(|| text[1..].to_owned())?
        }
        Value::Array(items) => Value::Array(items.iter().map(|item| fill_in(item, given)).collect::<Result<_, _>>()?),
        Value::Object(fields) => Value::Object(
            fields.iter().map(|(key, item)| Ok((key.clone(), fill_in(item, given)?))).collect::<Result<_, String>>()?,
        ),
        other => other.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn fractions_read_from_numbers_and_percentages() {
        let read = |value: Value| serde_json::from_value::<Fraction>(value).ok();
        assert_eq!(read(json!("0.3%")), Some(Fraction(0.003)));
        assert_eq!(read(json!(0.01)), Some(Fraction(0.01)));
        for refused in [json!("0.3"), json!(0), json!(1.5), json!("-1%"), json!([1])] {
            assert!(read(refused.clone()).is_none(), "{refused}");
        }
    }

    #[test]
    fn names_are_filled_in_at_any_depth() {
        let given = json!({ "rho": 0.5 });
        let Value::Object(given) = given else { return };
        assert_eq!(fill_in(&json!({ "a": [1, "$rho", "x"] }), &given), Ok(json!({ "a": [1, 0.5, "x"] })));
        assert_eq!(fill_in(&json!("$tau"), &given), Err("tau".to_owned()));
    }
}
