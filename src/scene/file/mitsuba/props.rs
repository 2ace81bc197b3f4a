//! The typed properties of an element: what is asked for is remembered, so that what nobody asked for is found.

use std::cell::RefCell;

use glam::{DAffine3, DVec3};

use super::document::{Document, Node, NodeId};
use super::transform;
use crate::scene::file::Notes;
use crate::scene::file::error::{Place, SceneError, listed, quoted};

/// Elements that are objects of their own, not values.
pub(super) const OBJECTS: [&str; 12] = [
    "bsdf",
    "emitter",
    "film",
    "integrator",
    "medium",
    "phase",
    "rfilter",
    "sampler",
    "sensor",
    "shape",
    "texture",
    "volume",
];

/// Objects within objects. A reference may lead back to where it stands.
const DEEPEST_OBJECT: usize = 16;

/// The properties of one element.
#[derive(Debug)]
pub(super) struct Props<'d> {
    pub(super) document: &'d Document,
    pub(super) node: &'d Node,
    /// The children, references resolved, under the names that this element gives them.
    children: Vec<Child<'d>>,
    known: RefCell<Vec<&'static str>>,
}

#[derive(Debug)]
struct Child<'d> {
    name: &'d str,
    id: NodeId,
    taken: RefCell<bool>,
}

impl<'d> Props<'d> {
    /// The properties of `id`, which is no reference.
    pub(super) fn new(document: &'d Document, id: NodeId) -> Result<Self, SceneError> {
        let node = document.node(id);
        let mut children: Vec<Child<'d>> = Vec::with_capacity(node.children.len());
        for &child in &node.children {
            let id = document.resolve(child)?;
            let (outer, inner) = (document.node(child), document.node(id));
            // A reference without a name gives its element none: the name of a named element belongs to its parent.
            let name = outer.name.as_str();
            if !name.is_empty() && children.iter().any(|other| other.name == name) {
                return Err(SceneError::Value {
                    place: document.place(outer),
                    what: "the name of a property".into(),
                    given: quoted(name),
                    allowed: format!("one that {} does not have yet", node.shown()),
                });
            }
            debug_assert!(inner.tag != "ref");
            children.push(Child { name, id, taken: RefCell::new(false) });
        }
        Ok(Self { document, node, children, known: RefCell::default() })
    }

    pub(super) fn place(&self) -> Place {
        self.document.place(self.node)
    }

    /// An error if objects contain each other too deeply, or forever.
    pub(super) fn check_depth(&self, depth: usize) -> Result<(), SceneError> {
        if depth < DEEPEST_OBJECT {
            return Ok(());
        }
        let what = format!("objects within objects, at {}", self.node.shown());
        Err(SceneError::TooMany { place: self.place(), what, most: DEEPEST_OBJECT as u64 })
    }

    /// The property `name`, if it is there: an element with one of these tags.
    pub(super) fn find(&self, name: &'static str, tags: &[&str]) -> Result<Option<NodeId>, SceneError> {
        self.known.borrow_mut().push(name);
        let Some(child) = self.children.iter().find(|child| child.name == name) else { return Ok(None) };
        *child.taken.borrow_mut() = true;
        let node = self.document.node(child.id);
        if !tags.contains(&node.tag.as_str()) {
            return Err(SceneError::Value {
                place: self.document.place(node),
                what: name.into(),
                given: node.shown(),
                allowed: listed(tags.iter().copied()),
            });
        }
        Ok(Some(child.id))
    }

    /// All children with this tag, whatever their names.
    pub(super) fn objects(&self, tag: &'static str) -> Vec<NodeId> {
        self.known.borrow_mut().push(tag);
        let mut found = Vec::new();
        for child in &self.children {
            if self.document.node(child.id).tag == tag && !*child.taken.borrow() {
                *child.taken.borrow_mut() = true;
                found.push(child.id);
            }
        }
        found
    }

    /// At most one child with this tag.
    pub(super) fn object(&self, tag: &'static str) -> Result<Option<NodeId>, SceneError> {
        let found = self.objects(tag);
        match found.get(1) {
            None => Ok(found.first().copied()),
            Some(&second) => Err(SceneError::Value {
                place: self.document.place(self.document.node(second)),
                what: format!("a second <{tag}>"),
                given: self.document.node(second).shown(),
                allowed: format!("one in {}", self.node.shown()),
            }),
        }
    }

    /// The attribute `value` of the property `name`.
    fn value(&self, name: &'static str, tags: &[&str]) -> Result<Option<&'d str>, SceneError> {
        let Some(id) = self.find(name, tags)? else { return Ok(None) };
        let node = self.document.node(id);
        match node.attribute("value") {
            Some(value) => Ok(Some(value.trim())),
            None => Err(SceneError::Missing {
                place: self.document.place(node),
                what: format!("the value of {}", node.shown()),
                allowed: "the attribute `value`".into(),
            }),
        }
    }

    pub(super) fn optional_float(&self, name: &'static str) -> Result<Option<f64>, SceneError> {
        let Some(text) = self.value(name, &["float", "integer"])? else { return Ok(None) };
        number(text).map(Some).ok_or_else(|| self.bad(name, text, "a finite number"))
    }

    /// The number `name`, if there is something of this name and it is a number.
    pub(super) fn number(&self, name: &'static str) -> Result<Option<f64>, SceneError> {
        let child = self.children.iter().find(|child| child.name == name);
        let is_text = child.is_some_and(|child| self.document.node(child.id).tag == "string");
        if is_text { Ok(None) } else { self.optional_float(name) }
    }

    pub(super) fn float(&self, name: &'static str, default: f64) -> Result<f64, SceneError> {
        Ok(self.optional_float(name)?.unwrap_or(default))
    }

    /// A number > 0.
    pub(super) fn positive(&self, name: &'static str, default: f64) -> Result<f64, SceneError> {
        let value = self.float(name, default)?;
        if value > 0.0 { Ok(value) } else { Err(self.bad(name, &value.to_string(), "a number > 0")) }
    }

    /// A number > 0 that must be there.
    pub(super) fn required_positive(&self, name: &'static str) -> Result<f64, SceneError> {
        match self.optional_float(name)? {
            None => Err(self.missing(name, "a number > 0")),
            Some(value) => self.positive(name, value),
        }
    }

    pub(super) fn optional_integer(&self, name: &'static str) -> Result<Option<i64>, SceneError> {
        let Some(text) = self.value(name, &["integer"])? else { return Ok(None) };
        text.parse().map(Some).map_err(|_| self.bad(name, text, "a whole number"))
    }

    pub(super) fn boolean(&self, name: &'static str, default: bool) -> Result<bool, SceneError> {
        match self.value(name, &["boolean"])? {
            None => Ok(default),
            Some("true") => Ok(true),
            Some("false") => Ok(false),
            Some(other) => Err(self.bad(name, other, "true, false")),
        }
    }

    pub(super) fn string(&self, name: &'static str) -> Result<Option<&'d str>, SceneError> {
        self.value(name, &["string"])
    }

    /// One of a few words.
    pub(super) fn word(&self, name: &'static str, words: &[&'static str]) -> Result<&'static str, SceneError> {
        let given = self.string(name)?.unwrap_or(words[0]);
        let found = words.iter().find(|word| word.eq_ignore_ascii_case(given));
        found.copied().ok_or_else(|| self.bad(name, given, &listed(words.iter().copied())))
    }

    pub(super) fn vector(&self, name: &'static str) -> Result<Option<DVec3>, SceneError> {
        let Some(id) = self.find(name, &["point", "vector"])? else { return Ok(None) };
        let node = self.document.node(id);
        transform::vector(self.document, node, 0.0).map(Some)
    }

    pub(super) fn transform(&self, name: &'static str) -> Result<Option<DAffine3>, SceneError> {
        let Some(id) = self.find(name, &["transform"])? else { return Ok(None) };
        transform::composed(self.document, self.document.node(id)).map(Some)
    }

    /// The error for a bad value of the property `name`.
    pub(super) fn bad(&self, name: &str, given: &str, allowed: &str) -> SceneError {
        let child = self.children.iter().find(|child| child.name == name);
        let node = child.map_or(self.node, |child| self.document.node(child.id));
        SceneError::Value {
            place: self.document.place(node),
            what: name.into(),
            given: quoted(given),
            allowed: allowed.into(),
        }
    }

    /// The error for the absence of `what`.
    pub(super) fn missing(&self, what: &str, allowed: &str) -> SceneError {
        let what = format!("{what} of {}", self.node.shown());
        SceneError::Missing { place: self.place(), what, allowed: allowed.into() }
    }

    /// The error for a type of this element that is not known.
    pub(super) fn unknown_kind(&self, known: &[&str]) -> SceneError {
        let (place, what) = (self.place(), self.node.shown());
        SceneError::Unsupported { place, what, known: listed(known.iter().copied()) }
    }

    /// The error for something that this element asks for.
    pub(super) fn unsupported(&self, name: &str, what: impl Into<String>, known: &str) -> SceneError {
        let child = self.children.iter().find(|child| child.name == name);
        let node = child.map_or(self.node, |child| self.document.node(child.id));
        SceneError::Unsupported { place: self.document.place(node), what: what.into(), known: known.into() }
    }

    /// Properties that change nothing in what is computed here.
    pub(super) fn no_effect(&self, names: &[&'static str]) {
        for &name in names {
            self.known.borrow_mut().push(name);
            for child in self.children.iter().filter(|child| child.name == name) {
                *child.taken.borrow_mut() = true;
            }
        }
    }

    /// Errors, or warnings, for every child that nobody asked for.
    pub(super) fn finish(self, notes: &Notes) -> Result<(), SceneError> {
        for child in self.children.iter().filter(|child| !*child.taken.borrow()) {
            let node = self.document.node(child.id);
            let known = self.known.borrow();
            let what = match child.name {
                "" => format!("{} in {}", node.shown(), self.node.shown()),
                name => format!("{} of {}", quoted(name), self.node.shown()),
            };
            let known = listed(known.iter().copied());
            let place = self.document.place(node);
            notes.unsupported(SceneError::Unsupported { place, what, known }, "it is ignored")?;
        }
        Ok(())
    }
}

/// A finite number.
pub(super) fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|x: &f64| x.is_finite())
}

/// Numbers between commas or spaces.
pub(super) fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty()).map(number).collect()
}
