//! The one length unit of a model, and lengths with a unit of their own.

use serde::{Deserialize, Serialize, Serializer};

/// The unit of every length of a model.
///
/// There is no default: a manifest without a unit is an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum LengthUnit {
    /// Metre, `m`.
    #[serde(rename = "m")]
    Metre,
    /// Decimetre, `dm`.
    #[serde(rename = "dm")]
    Decimetre,
    /// Centimetre, `cm`.
    #[serde(rename = "cm")]
    Centimetre,
    /// Millimetre, `mm`.
    #[serde(rename = "mm")]
    Millimetre,
    /// Micrometre, `um`.
    #[serde(rename = "um")]
    Micrometre,
    /// Inch, `in`.
    #[serde(rename = "in")]
    Inch,
    /// Foot, `ft`.
    #[serde(rename = "ft")]
    Foot,
}

/// Why a text is not a length or a length unit.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LengthError {
    /// The unit's symbol is unknown.
    #[error("unknown length unit {0:?}; known are m, dm, cm, mm, um, in, ft")]
    UnknownUnit(String),
    /// The text does not begin with a finite number.
    #[error("{0:?} is not a length; write a number and a unit, such as 1mm")]
    NotANumber(String),
}

impl LengthUnit {
    /// All units, the metric ones first.
    pub const ALL: [Self; 7] = [
        Self::Metre,
        Self::Decimetre,
        Self::Centimetre,
        Self::Millimetre,
        Self::Micrometre,
        Self::Inch,
        Self::Foot,
    ];

    /// Symbol, and length in metres.
    const fn definition(self) -> (&'static str, f64) {
        match self {
            Self::Metre => ("m", 1.0),
            Self::Decimetre => ("dm", 0.1),
            Self::Centimetre => ("cm", 0.01),
            Self::Millimetre => ("mm", 1e-3),
            Self::Micrometre => ("um", 1e-6),
            Self::Inch => ("in", 0.0254),
            Self::Foot => ("ft", 0.3048),
        }
    }

    /// The symbol in manifests and reports, such as `mm`.
    pub const fn symbol(self) -> &'static str {
        self.definition().0
    }

    /// Length of one unit in metres.
    pub const fn in_metres(self) -> f64 {
        self.definition().1
    }

    /// A length such as `1mm`, `0.5 in` or `2`, converted to this unit; a bare number is in this
    /// unit.
    ///
    /// # Errors
    /// [`LengthError`] if the number is not finite or the unit is unknown.
    ///
    /// ```
    /// use transect_geometry::LengthUnit;
    /// let in_metres = LengthUnit::Metre.parse_length("2.5mm").unwrap();
    /// assert!((in_metres - 0.0025).abs() < 1e-15);
    /// ```
    pub fn parse_length(self, text: &str) -> Result<f64, LengthError> {
        Ok(text.parse::<Length>()?.in_unit(self))
    }
}

/// A length with a unit of its own, or in the model's unit. It is finite.
///
/// As text: a number and a unit, such as `1mm` or `0.5 in`. A bare number is in the model's unit.
///
/// ```
/// use transect_geometry::{Length, LengthUnit};
/// let length: Length = "2.5mm".parse()?;
/// assert_eq!(length.in_unit(LengthUnit::Micrometre), 2500.0);
/// let bare: Length = "3".parse()?;
/// assert_eq!(bare.in_unit(LengthUnit::Inch), 3.0);
/// # Ok::<(), transect_geometry::LengthError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    value: f64,
    /// `None` for the model's unit.
    unit: Option<LengthUnit>,
}

impl Length {
    /// A length in a unit; `None` stands for the model's unit.
    ///
    /// # Errors
    /// [`LengthError::NotANumber`] if the value is not finite.
    pub fn new(value: f64, unit: Option<LengthUnit>) -> Result<Self, LengthError> {
        let length = Self { value, unit };
        if value.is_finite() {
            Ok(length)
        } else {
            Err(LengthError::NotANumber(length.to_string()))
        }
    }

    /// The length in the model's unit, which is `model`.
    pub fn in_unit(self, model: LengthUnit) -> f64 {
        match self.unit {
            Some(unit) if unit != model => self.value * unit.in_metres() / model.in_metres(),
            _ => self.value,
        }
    }

    /// Whether it is over 0.
    pub fn is_positive(self) -> bool {
        self.value > 0.0
    }
}

impl std::fmt::Display for Length {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}", self.value, self.unit.map_or("", LengthUnit::symbol))
    }
}

impl Serialize for Length {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        out.collect_str(self)
    }
}

impl std::str::FromStr for Length {
    type Err = LengthError;

    fn from_str(text: &str) -> Result<Self, LengthError> {
        let text = text.trim();
        let is_symbol = |c: char| c.is_ascii_alphabetic();
        let symbol_length = text.chars().rev().take_while(|&c| is_symbol(c)).count();
        let (number, symbol) = text.split_at(text.len() - symbol_length);
        let not_a_number = || LengthError::NotANumber(text.to_owned());
        let value: f64 = number.trim().parse().map_err(|_| not_a_number())?;
        if !value.is_finite() {
            return Err(not_a_number());
        }
        let unit = if symbol.is_empty() { None } else { Some(symbol.parse()?) };
        Ok(Self { value, unit })
    }
}

impl std::fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.symbol())
    }
}

impl std::str::FromStr for LengthUnit {
    type Err = LengthError;

    fn from_str(symbol: &str) -> Result<Self, LengthError> {
        let known = Self::ALL.into_iter().find(|u| u.symbol() == symbol);
        known.ok_or_else(|| LengthError::UnknownUnit(symbol.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_convert_to_the_model_unit() {
        assert_eq!(LengthUnit::Metre.parse_length("1mm"), Ok(0.001));
        assert_eq!(LengthUnit::Millimetre.parse_length("1in"), Ok(25.4));
        assert_eq!(LengthUnit::Metre.parse_length("-0.25"), Ok(-0.25));
        assert_eq!(LengthUnit::Metre.parse_length("1e-3 m"), Ok(0.001));
    }

    #[test]
    fn lengths_are_written_as_they_are_read() {
        for text in ["1mm", "-0.25", "12.5ft"] {
            assert_eq!(text.parse::<Length>().unwrap().to_string(), text);
        }
        let infinite = Length::new(f64::INFINITY, Some(LengthUnit::Foot)).unwrap_err();
        assert!(infinite.to_string().starts_with("\"infft\" is not a length"), "{infinite}");
    }

    #[test]
    fn bad_lengths_are_named() {
        let unknown = LengthUnit::Metre.parse_length("1furlong").unwrap_err();
        assert!(unknown.to_string().contains("\"furlong\""), "{unknown}");
        for text in ["", "mm", "inf", "NaNm", "1,5mm"] {
            let bad = LengthUnit::Metre.parse_length(text).unwrap_err();
            assert!(matches!(bad, LengthError::NotANumber(_)), "{text}");
        }
    }
}
