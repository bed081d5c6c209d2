//! What a picture says about itself.

/// Named texts that go into a picture's file: who made it, by which command, from which seed.
///
/// Names are kept in the order given; a name that is set twice keeps its place and takes the new value.
///
/// ```
/// let mut m = etendue_image::Metadata::default();
/// m.set("Software", "etendue 0.1.0");
/// m.set("Samples", "256");
/// assert_eq!(m.get("Samples"), Some("256"));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Metadata {
    /// Names and values in order.
    pub entries: Vec<(String, String)>,
}

impl Metadata {
    /// Sets `name` to `value`.
    pub fn set(&mut self, name: impl Into<String>, value: impl Into<String>) {
        let (name, value) = (name.into(), value.into());
        match self.entries.iter_mut().find(|e| e.0 == name) {
            Some(e) => e.1 = value,
            None => self.entries.push((name, value)),
        }
    }

    /// The value of `name`, if it is set.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.entries.iter().find(|e| e.0 == name).map(|e| e.1.as_str())
    }
}
