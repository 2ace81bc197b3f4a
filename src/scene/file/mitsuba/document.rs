//! The elements of a Mitsuba file, with its includes spliced in and its parameters put in their places.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::scene::file::Notes;
use crate::scene::file::error::{Place, SceneError, listed, one_line, quoted};
use crate::scene::file::source;

/// Includes within includes, and elements within elements.
const DEEPEST_INCLUDE: usize = 15;
const DEEPEST_ELEMENT: usize = 64;
/// Elements after includes: files that include one another many times over grow without bound.
const MOST_ELEMENTS: usize = 2_000_000;
const MOST_INCLUDES: usize = 10_000;
/// A parameter may stand for others, and those for others still.
const MOST_SUBSTITUTED: usize = 64 << 20;

/// The number of an element in its [`Document`].
pub(super) type NodeId = usize;

/// One element.
#[derive(Debug)]
pub(super) struct Node {
    /// The name of the element.
    pub(super) tag: String,
    /// Its attribute `type`, or "".
    pub(super) kind: String,
    /// Its attribute `name` in snake_case, or "".
    pub(super) name: String,
    /// Its attribute `id`, or "".
    pub(super) id: String,
    /// All other attributes.
    pub(super) attributes: Vec<(String, String)>,
    pub(super) children: Vec<NodeId>,
    file: usize,
    line: u64,
}

impl Node {
    /// The value of the attribute `name`.
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }

    /// The element as its file spells it, as far as errors need it.
    pub(super) fn shown(&self) -> String {
        let part = |attribute: &str, value: &str| {
            if value.is_empty() { String::new() } else { format!(" {attribute}=\"{}\"", one_line(value, 40)) }
        };
        format!("<{}{}{}>", one_line(&self.tag, 40), part("type", &self.kind), part("name", &self.name))
    }
}

/// A Mitsuba file with everything that it includes.
#[derive(Debug, Default)]
pub(super) struct Document {
    nodes: Vec<Node>,
    files: Vec<PathBuf>,
    /// Folders in which files are looked for.
    folders: Vec<PathBuf>,
    ids: BTreeMap<String, NodeId>,
    /// The children of the root.
    pub(super) roots: Vec<NodeId>,
}

impl Document {
    /// Reads `path`, with the values of `params` in place of those that the file declares.
    pub(super) fn read(path: &Path, params: &[(String, String)], notes: &Notes) -> Result<Self, SceneError> {
        let given = params.iter().map(|(name, value)| (name.clone(), value.clone())).collect();
        let mut reader = Reader {
            document: Self::default(),
            notes,
            values: given,
            used: BTreeSet::new(),
            substituted: 0,
            open: Vec::new(),
            includes: 0,
            aliases: Vec::new(),
        };
        reader.document.folders.extend(path.parent().map(Path::to_path_buf));
        reader.document.roots = reader.file(path, None)?;
        if let Some((unknown, _)) = params.iter().find(|(name, _)| !reader.used.contains(name)) {
            return Err(SceneError::Unsupported {
                place: Place::whole(path),
                what: format!("the parameter {}", quoted(unknown)),
                known: listed(reader.used.iter().map(String::as_str)),
            });
        }
        reader.resolve_aliases()?;
        Ok(reader.document)
    }

    pub(super) fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id]
    }

    /// Where an element is.
    pub(super) fn place(&self, node: &Node) -> Place {
        Place::line(&self.files[node.file], node.line)
    }

    /// The element that `id` is or, if it is a reference, that it refers to.
    pub(super) fn resolve(&self, id: NodeId) -> Result<NodeId, SceneError> {
        let node = self.node(id);
        if node.tag != "ref" {
            return Ok(id);
        }
        self.ids.get(&node.id).copied().ok_or_else(|| SceneError::Value {
            place: self.place(node),
            what: "the id of <ref>".into(),
            given: quoted(&node.id),
            allowed: format!("the id of an element: {}", listed(self.ids.keys().map(String::as_str))),
        })
    }

    /// Finds a file that `node` names: beside its own file, beside the first, or in the folders that `<path>` adds.
    pub(super) fn find_file(&self, node: &Node, name: &str) -> PathBuf {
        let name = Path::new(name);
        let beside = self.files[node.file].parent().into_iter();
        let mut candidates = beside.chain(self.folders.iter().map(PathBuf::as_path)).map(|folder| folder.join(name));
        candidates.find(|path| path.exists()).unwrap_or_else(|| self.files[node.file].with_file_name("").join(name))
    }
}

/// Reads files one into another.
struct Reader<'n> {
    document: Document,
    notes: &'n Notes,
    values: BTreeMap<String, String>,
    /// The parameters that the files declare or use.
    used: BTreeSet<String>,
    /// The bytes put in the places of parameters so far.
    substituted: usize,
    /// The files being read, outermost first.
    open: Vec<PathBuf>,
    includes: usize,
    /// `<alias id= as=>`, in order.
    aliases: Vec<(String, String, Place)>,
}

impl Reader<'_> {
    /// The children of the root of `path`.
    fn file(&mut self, path: &Path, asked: Option<&Place>) -> Result<Vec<NodeId>, SceneError> {
        let real = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        let place = asked.cloned().unwrap_or_else(|| Place::whole(path));
        if self.open.contains(&real) {
            return Err(SceneError::Value {
                place,
                what: "the filename of <include>".into(),
                given: quoted(&path.to_string_lossy()),
                allowed: "a file that does not include itself".into(),
            });
        }
        self.includes += 1;
        if self.open.len() > DEEPEST_INCLUDE {
            return Err(SceneError::TooMany {
                place,
                what: "includes in includes".into(),
                most: DEEPEST_INCLUDE as u64,
            });
        }
        if self.includes > MOST_INCLUDES {
            return Err(SceneError::TooMany { place, what: "includes".into(), most: MOST_INCLUDES as u64 });
        }
        let text = source::read_text(path, asked)?;
        // Document types are refused: entities that expand to others are how small files fill large memories.
        let options = roxmltree::ParsingOptions { nodes_limit: 3 * MOST_ELEMENTS as u32, ..Default::default() };
        let tree = roxmltree::Document::parse_with_options(&text, options).map_err(|e| malformed(path, &e))?;
        let file = self.document.files.len();
        self.document.files.push(path.to_path_buf());
        let lines = Lines::new(&text);
        let root = tree.root_element();
        if root.tag_name().name() != "scene" {
            return Err(SceneError::Unsupported {
                place: Place::line(path, lines.of(root)),
                what: format!("a file whose root is <{}>", one_line(root.tag_name().name(), 40)),
                known: "<scene> (Mitsuba)".into(),
            });
        }
        self.open.push(real);
        let roots = self.children(root, file, &lines, 0)?;
        self.open.pop();
        Ok(roots)
    }

    /// The elements within `parent`, except those that speak to the reader.
    fn children(
        &mut self,
        parent: roxmltree::Node<'_, '_>,
        file: usize,
        lines: &Lines,
        depth: usize,
    ) -> Result<Vec<NodeId>, SceneError> {
        let mut children = Vec::new();
        for child in parent.children() {
            let place = || Place::line(&self.document.files[file], lines.of(child));
            if let Some(text) = child.text().filter(|text| child.is_text() && !text.trim().is_empty()) {
                return Err(SceneError::Malformed {
                    place: place(),
                    problem: format!("text {} between elements", quoted(text.trim())),
                    allowed: "elements only".into(),
                });
            }
            if !child.is_element() {
                continue;
            }
            if depth >= DEEPEST_ELEMENT {
                let most = DEEPEST_ELEMENT as u64;
                return Err(SceneError::TooMany { place: place(), what: "elements in elements".into(), most });
            }
            if self.document.nodes.len() >= MOST_ELEMENTS {
                let most = MOST_ELEMENTS as u64;
                return Err(SceneError::TooMany { place: place(), what: "elements".into(), most });
            }
            let node = self.node(child, file, lines.of(child))?;
            match node.tag.as_str() {
                "include" => {
                    let (name, place) = (self.required(&node, "filename")?, self.document.place(&node));
                    let path = self.document.find_file(&node, &name);
                    children.extend(self.file(&path, Some(&place))?);
                }
                "path" => {
                    let name = self.required(&node, "value")?;
                    let folder = self.document.find_file(&node, &name);
                    self.document.folders.push(folder);
                }
                "default" => {
                    let (name, value) = (self.required(&node, "name")?, self.required(&node, "value")?);
                    self.used.insert(name.clone());
                    self.values.entry(name).or_insert(value);
                }
                "alias" => {
                    let alias = (self.required(&node, "id")?, self.required(&node, "as")?, self.document.place(&node));
                    self.aliases.push(alias);
                }
                _ => {
                    let id = self.document.nodes.len();
                    self.declare(&node, id)?;
                    self.document.nodes.push(node);
                    self.document.nodes[id].children = self.children(child, file, lines, depth + 1)?;
                    children.push(id);
                }
            }
        }
        Ok(children)
    }

    /// The element alone, with parameters put in their places.
    fn node(&mut self, element: roxmltree::Node<'_, '_>, file: usize, line: u64) -> Result<Node, SceneError> {
        let tag = snake_case(element.tag_name().name());
        let mut node = Node {
            kind: String::new(),
            name: String::new(),
            id: String::new(),
            attributes: Vec::new(),
            children: Vec::new(),
            file,
            line,
            tag: if tag == "look_at" { "lookat".into() } else { tag },
        };
        for attribute in element.attributes() {
            let value = self.substituted(attribute.value(), &node)?;
            match attribute.name() {
                "type" => node.kind = value,
                // What <default> names is text of the file's own.
                "name" if node.tag != "default" => node.name = snake_case(&value),
                "id" if node.tag != "alias" => node.id = value,
                name => {
                    if let Some(known) = attributes_of(&node.tag).filter(|known| !known.contains(&name)) {
                        let place = self.document.place(&node);
                        let what = format!("the attribute {} of <{}>", quoted(name), node.tag);
                        let known = listed(["type", "name", "id"].iter().chain(known).copied());
                        let error = SceneError::Unsupported { place, what, known };
                        self.notes.unsupported(error, "it is ignored")?;
                    }
                    node.attributes.push((name.to_string(), value));
                }
            }
        }
        Ok(node)
    }

    /// `text` with the values of the parameters that it names as `$name`.
    fn substituted(&mut self, text: &str, node: &Node) -> Result<String, SceneError> {
        let mut rest = text;
        let mut whole = String::new();
        while let Some((before, after)) = rest.split_once('$') {
            whole.push_str(before);
            let length = after.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(after.len());
            let (name, behind) = after.split_at(length);
            let Some(value) = self.values.get(name) else {
                return Err(SceneError::Value {
                    place: self.document.place(node),
                    what: "the parameter".into(),
                    given: quoted(&format!("${name}")),
                    allowed: format!("a name that has a <default> above: {}", listed(self.declared())),
                });
            };
            whole.push_str(value);
            self.used.insert(name.to_string());
            self.substituted += value.len();
            if self.substituted > MOST_SUBSTITUTED {
                let what = "bytes in the values of parameters".into();
                return Err(SceneError::TooMany {
                    place: self.document.place(node),
                    what,
                    most: MOST_SUBSTITUTED as u64,
                });
            }
            rest = behind;
        }
        whole.push_str(rest);
        Ok(whole)
    }

    fn declared(&self) -> impl Iterator<Item = &str> {
        self.values.keys().map(String::as_str)
    }

    fn declare(&mut self, node: &Node, id: NodeId) -> Result<(), SceneError> {
        if node.id.is_empty() || node.tag == "ref" {
            return Ok(());
        }
        match self.document.ids.insert(node.id.clone(), id) {
            None => Ok(()),
            Some(first) => Err(SceneError::Value {
                place: self.document.place(node),
                what: "id".into(),
                given: quoted(&node.id),
                allowed: format!("an id that is not taken: {} has it", self.document.place(self.document.node(first))),
            }),
        }
    }

    fn resolve_aliases(&mut self) -> Result<(), SceneError> {
        for (id, other, place) in std::mem::take(&mut self.aliases) {
            let Some(&node) = self.document.ids.get(&id) else {
                let allowed = format!("the id of an element: {}", listed(self.document.ids.keys().map(String::as_str)));
                return Err(SceneError::Value { place, what: "the id of <alias>".into(), given: quoted(&id), allowed });
            };
            self.document.ids.insert(other, node);
        }
        Ok(())
    }

    fn required(&self, node: &Node, attribute: &str) -> Result<String, SceneError> {
        node.attribute(attribute).map(str::to_string).ok_or_else(|| SceneError::Missing {
            place: self.document.place(node),
            what: format!("the attribute {attribute} of <{}>", node.tag),
            allowed: format!("<{} {attribute}=\"…\"/>", node.tag),
        })
    }
}

/// The attributes that an element may have besides type, name and id. None for an element that is refused later.
fn attributes_of(tag: &str) -> Option<&'static [&'static str]> {
    Some(match tag {
        "float" | "integer" | "boolean" | "string" | "rgb" | "srgb" | "matrix" | "path" => &["value"],
        "default" => &["name", "value"],
        "spectrum" => &["value", "filename"],
        "point" | "vector" | "translate" | "scale" => &["value", "x", "y", "z"],
        "rotate" => &["value", "x", "y", "z", "angle"],
        "lookat" => &["origin", "target", "up"],
        "include" => &["filename"],
        "alias" => &["id", "as"],
        "ref" | "transform" => &[],
        _ if super::props::OBJECTS.contains(&tag) => &["version"],
        _ => return None,
    })
}

fn malformed(path: &Path, error: &roxmltree::Error) -> SceneError {
    let (problem, allowed) = match error {
        roxmltree::Error::DtdDetected => ("a document type".to_string(), "XML without <!DOCTYPE> and entities"),
        roxmltree::Error::NodesLimitReached => ("more elements than are read".into(), "at most two million"),
        other => (one_line(&other.to_string(), 200), "well-formed XML"),
    };
    let place = Place::line(path, u64::from(error.pos().row));
    SceneError::Malformed { place, problem, allowed: allowed.into() }
}

/// Where lines begin, so that a position costs a search and not a count.
struct Lines(Vec<usize>);

impl Lines {
    fn new(text: &str) -> Self {
        Self(std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect())
    }

    fn of(&self, node: roxmltree::Node<'_, '_>) -> u64 {
        self.0.partition_point(|&start| start <= node.range().start) as u64
    }
}

/// `toWorld` → `to_world`, `intIOR` → `int_ior`: older files write names so.
pub(super) fn snake_case(name: &str) -> String {
    let mut snake = String::with_capacity(name.len() + 4);
    let mut after_small = false;
    for c in name.chars() {
        if c.is_ascii_uppercase() && after_small {
            snake.push('_');
        }
        after_small = c.is_ascii_lowercase() || c.is_ascii_digit();
        snake.push(c.to_ascii_lowercase());
    }
    snake
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn older_names() {
        let old = ["toWorld", "intIOR", "alphaU", "fov", "sampleCount", "to_world", "specularReflectance"];
        let new = ["to_world", "int_ior", "alpha_u", "fov", "sample_count", "to_world", "specular_reflectance"];
        assert_eq!(old.map(snake_case), new);
    }
}
