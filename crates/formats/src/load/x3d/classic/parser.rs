//! Statements of a classic text as a tree. A value's kind follows from its first token, so that
//! fields of unknown nodes can be read as well.

use super::lexer::{Kind, Lexer, Token};
use crate::load::LoadError;
use crate::load::x3d::xml::{MAX_DEPTH, XmlSource};
use fbptr_core::cancel::CancelToken;

/// Most bytes of a node type's name: a USE repeats it.
const MAX_TYPE_NAME: usize = 128;

/// Most fields of one node: each is compared with those before it.
const MAX_FIELDS: usize = 256;

/// A name or another part of the text, with its byte offset.
#[derive(Clone, Copy, Debug)]
pub(super) struct Name<'s> {
    pub(super) text: &'s str,
    pub(super) at: usize,
}

impl<'s> From<Token<'s>> for Name<'s> {
    fn from(token: Token<'s>) -> Self {
        Name { text: token.text, at: token.at }
    }
}

/// A statement, in a file, a prototype's body, or a list of nodes.
#[derive(Debug)]
pub(super) enum Statement<'s> {
    Node(Node<'s>),
    Use(Name<'s>),
    Proto(Proto<'s>),
    Route {
        at: usize,
        from: [&'s str; 2],
        to: [&'s str; 2],
    },
    /// UNIT: category, name and factor.
    Unit {
        at: usize,
        words: [&'s str; 3],
    },
    /// IMPORT or EXPORT, which no reader here follows.
    Elsewhere(Name<'s>),
}

/// A node.
#[derive(Debug)]
pub(super) struct Node<'s> {
    pub(super) ty: Name<'s>,
    pub(super) def: Option<Name<'s>>,
    pub(super) fields: Vec<Field<'s>>,
    /// Fields that a script declares.
    pub(super) declared: Vec<Declared<'s>>,
    /// Prototypes and routes in its body.
    pub(super) inner: Vec<Statement<'s>>,
}

/// A field of a node.
#[derive(Debug)]
pub(super) struct Field<'s> {
    pub(super) name: Name<'s>,
    pub(super) value: Value<'s>,
}

/// Value of a field.
#[derive(Debug)]
pub(super) enum Value<'s> {
    /// Numbers or truth values with the comments between them.
    Words(Name<'s>),
    /// Strings with their quotes.
    Strings(Vec<Name<'s>>),
    Nodes(Vec<Statement<'s>>),
    /// An empty list, or NULL.
    Empty,
    /// IS: the prototype's field.
    Is(Name<'s>),
}

/// A field in the interface of a prototype or of a script.
#[derive(Debug)]
pub(super) struct Declared<'s> {
    /// Access type, in X3D's words.
    pub(super) access: &'static str,
    pub(super) ty: Name<'s>,
    pub(super) name: Name<'s>,
    pub(super) value: Option<Value<'s>>,
}

/// A prototype.
#[derive(Debug)]
pub(super) struct Proto<'s> {
    pub(super) name: Name<'s>,
    pub(super) interface: Vec<Declared<'s>>,
    pub(super) body: Body<'s>,
}

#[derive(Debug)]
pub(super) enum Body<'s> {
    Own(Vec<Statement<'s>>),
    /// EXTERNPROTO: its URLs.
    Elsewhere(Vec<Name<'s>>),
}

/// Reads a whole file.
pub(super) fn file<'s>(
    source: &'s XmlSource,
    cancel: &'s CancelToken,
) -> Result<Vec<Statement<'s>>, LoadError> {
    let mut parser = Parser { lexer: Lexer::new(source, cancel)?, depth: 0 };
    let statements = parser.statements()?;
    match parser.lexer.next.kind {
        Kind::End => Ok(statements),
        _ => Err(parser.lexer.refuse("a node or a statement")),
    }
}

struct Parser<'s> {
    lexer: Lexer<'s>,
    /// Number of open nodes and prototypes.
    depth: usize,
}

/// Returns the access type that a word of either version means.
fn access(word: &str) -> Option<&'static str> {
    Some(match word {
        "eventIn" | "inputOnly" => "inputOnly",
        "eventOut" | "outputOnly" => "outputOnly",
        "field" | "initializeOnly" => "initializeOnly",
        "exposedField" | "inputOutput" => "inputOutput",
        _ => return None,
    })
}

impl<'s> Parser<'s> {
    fn word(&mut self, expected: &str) -> Result<Name<'s>, LoadError> {
        self.lexer.take_a(Kind::Word, expected).map(Name::from)
    }

    /// Enters a node or a prototype, whose first token was at `at`.
    fn enter(&mut self, at: usize) -> Result<(), LoadError> {
        self.depth += 1;
        match self.depth > MAX_DEPTH {
            true => {
                let limit = MAX_DEPTH as u64;
                Err(self.lexer.source.too_big(at, "nesting of nodes", self.depth as u64, limit))
            }
            false => Ok(()),
        }
    }

    /// Reads statements up to a closing bracket or the end.
    fn statements(&mut self) -> Result<Vec<Statement<'s>>, LoadError> {
        let mut statements = Vec::new();
        while self.lexer.next.kind == Kind::Word {
            statements.extend(self.statement()?);
        }
        Ok(statements)
    }

    /// Reads a statement; `None` for those that describe the file only.
    fn statement(&mut self) -> Result<Option<Statement<'s>>, LoadError> {
        let first = self.lexer.next;
        Ok(Some(match first.text {
            "USE" => {
                self.lexer.take()?;
                Statement::Use(self.word("a name after USE")?)
            }
            "PROTO" | "EXTERNPROTO" => self.proto()?,
            "ROUTE" => self.route()?,
            "UNIT" => {
                self.lexer.take()?;
                let mut word = || Ok(self.word("category, name and factor after UNIT")?.text);
                Statement::Unit { at: first.at, words: [word()?, word()?, word()?] }
            }
            "PROFILE" | "COMPONENT" => {
                self.lexer.take()?;
                self.word("a name after PROFILE or COMPONENT")?;
                return Ok(None);
            }
            "META" => {
                self.lexer.take()?;
                self.lexer.take_a(Kind::String, "two strings after META")?;
                self.lexer.take_a(Kind::String, "two strings after META")?;
                return Ok(None);
            }
            "IMPORT" | "EXPORT" => {
                self.lexer.take()?;
                self.word("a name after IMPORT or EXPORT")?;
                if self.lexer.next.text == "AS" {
                    self.lexer.take()?;
                    self.word("a name after AS")?;
                }
                Statement::Elsewhere(first.into())
            }
            _ => Statement::Node(self.node()?),
        }))
    }

    /// Reads `ROUTE node.field TO node.field`.
    fn route(&mut self) -> Result<Statement<'s>, LoadError> {
        let at = self.lexer.take()?.at;
        let from = self.end_of_route()?;
        match self.word("TO in a ROUTE")? {
            Name { text: "TO", .. } => {}
            Name { at, .. } => return Err(self.lexer.source.refuse(at, "TO in a ROUTE")),
        }
        Ok(Statement::Route { at, from, to: self.end_of_route()? })
    }

    fn end_of_route(&mut self) -> Result<[&'s str; 2], LoadError> {
        let expected = "node.field in a ROUTE";
        let name = self.word(expected)?;
        let (node, field) =
            name.text.rsplit_once('.').ok_or_else(|| self.lexer.source.refuse(name.at, expected))?;
        Ok([node, field])
    }

    fn node(&mut self) -> Result<Node<'s>, LoadError> {
        let def = match self.lexer.next.text {
            "DEF" => {
                self.lexer.take()?;
                Some(self.word("a name after DEF")?)
            }
            _ => None,
        };
        if self.lexer.next.is_value() || self.lexer.next.text.len() > MAX_TYPE_NAME {
            return Err(self.lexer.refuse("the type of a node"));
        }
        let ty = self.word("the type of a node")?;
        self.lexer.take_a(Kind::OpenNode, &format!("{{ after the node type {}", ty.text))?;
        self.enter(ty.at)?;
        let mut node = Node { ty, def, fields: Vec::new(), declared: Vec::new(), inner: Vec::new() };
        while self.lexer.next.kind == Kind::Word {
            match self.lexer.next.text {
                "ROUTE" | "PROTO" | "EXTERNPROTO" => node.inner.extend(self.statement()?),
                _ => self.field(&mut node)?,
            }
        }
        let expected = || {
            format!("a field or }}, which closes the {} of line {}", ty.text, self.lexer.source.line(ty.at))
        };
        if self.lexer.next.kind != Kind::CloseNode {
            return Err(self.lexer.refuse(expected()));
        }
        self.lexer.take()?;
        self.depth -= 1;
        Ok(node)
    }

    /// Reads a field of a node, or the declaration of one.
    fn field(&mut self, node: &mut Node<'s>) -> Result<(), LoadError> {
        let name: Name = self.lexer.take()?.into();
        let is_type = |t: Token| t.text.starts_with("SF") || t.text.starts_with("MF");
        if let (Some(access), true) = (access(name.text), is_type(self.lexer.next)) {
            node.declared.push(self.declared(access, Declares::Either)?);
            return Ok(());
        }
        if node.fields.len() == MAX_FIELDS {
            let (found, limit) = (MAX_FIELDS as u64 + 1, MAX_FIELDS as u64);
            return Err(self.lexer.source.too_big(name.at, "fields of one node", found, limit));
        }
        let value = self.value(name)?;
        let is_given = |f: &Field| {
            f.name.text == name.text && !matches!(f.value, Value::Nodes(_) | Value::Empty | Value::Is(_))
        };
        if node.fields.iter().any(is_given) {
            let expected = format!("the field {} once in this node", name.text);
            return Err(self.lexer.source.refuse(name.at, expected));
        }
        node.fields.push(Field { name, value });
        Ok(())
    }

    fn value(&mut self, name: Name<'s>) -> Result<Value<'s>, LoadError> {
        let next = self.lexer.next;
        Ok(match (next.kind, next.text) {
            (Kind::OpenList, _) => self.list(name)?,
            (Kind::String, _) => Value::Strings(vec![self.lexer.take()?.into()]),
            (Kind::Word, "IS") => {
                self.lexer.take()?;
                Value::Is(self.word("a field of the prototype after IS")?)
            }
            (Kind::Word, "NULL") => {
                self.lexer.take()?;
                Value::Empty
            }
            (Kind::Word, _) if next.is_value() => {
                let mut last = self.lexer.take()?;
                while self.lexer.next.is_value() {
                    last = self.lexer.take()?;
                }
                Value::Words(self.between(next.at, last.at + last.text.len()))
            }
            (Kind::Word, _) => Value::Nodes(self.statement()?.into_iter().collect()),
            _ => return Err(self.lexer.refuse(format!("a value of the field {}", name.text))),
        })
    }

    fn between(&self, from: usize, to: usize) -> Name<'s> {
        Name { text: &self.lexer.source.text[from..to], at: from }
    }

    /// Reads a list in brackets.
    fn list(&mut self, name: Name<'s>) -> Result<Value<'s>, LoadError> {
        let open = self.lexer.take()?;
        let first = self.lexer.next;
        let value = match first.kind {
            Kind::CloseList => Value::Empty,
            Kind::String => {
                let mut strings = Vec::new();
                while self.lexer.next.kind == Kind::String {
                    strings.push(self.lexer.take()?.into());
                }
                Value::Strings(strings)
            }
            _ if first.is_value() => {
                while self.lexer.next.kind == Kind::Word {
                    self.lexer.take()?;
                }
                Value::Words(self.between(open.at + 1, self.lexer.next.at))
            }
            _ => Value::Nodes(self.statements()?),
        };
        if self.lexer.next.kind != Kind::CloseList {
            let line = self.lexer.source.line(open.at);
            return Err(self
                .lexer
                .refuse(format!("a value or ], which closes the {} of line {line}", name.text)));
        }
        self.lexer.take()?;
        Ok(value)
    }

    fn proto(&mut self) -> Result<Statement<'s>, LoadError> {
        let keyword = self.lexer.take()?;
        let is_own = keyword.text == "PROTO";
        self.enter(keyword.at)?;
        let name = self.word("a name after PROTO or EXTERNPROTO")?;
        if name.text.len() > MAX_TYPE_NAME {
            return Err(self
                .lexer
                .source
                .refuse(name.at, format!("a name of at most {MAX_TYPE_NAME} bytes")));
        }
        self.lexer.take_a(Kind::OpenList, "[ before the fields of a prototype")?;
        let mut interface = Vec::new();
        while let (Kind::Word, Some(access)) = (self.lexer.next.kind, access(self.lexer.next.text)) {
            self.lexer.take()?;
            let declares = if is_own { Declares::Value } else { Declares::Nothing };
            interface.push(self.declared(access, declares)?);
        }
        self.lexer.take_a(Kind::CloseList, "a field of the prototype or ]")?;
        let body = match is_own {
            true => {
                self.lexer.take_a(Kind::OpenNode, "{ before the body of a prototype")?;
                let body = self.statements()?;
                self.lexer.take_a(Kind::CloseNode, "a node or }, which closes the prototype")?;
                Body::Own(body)
            }
            false => match self.value(name)? {
                Value::Strings(urls) => Body::Elsewhere(urls),
                Value::Empty => Body::Elsewhere(Vec::new()),
                _ => return Err(self.lexer.source.refuse(keyword.at, "the URLs of an EXTERNPROTO")),
            },
        };
        self.depth -= 1;
        Ok(Statement::Proto(Proto { name, interface, body }))
    }

    /// Reads type, name and value of a declared field.
    fn declared(&mut self, access: &'static str, declares: Declares) -> Result<Declared<'s>, LoadError> {
        let ty = self.word("the type of a field")?;
        let name = self.word("the name of a field")?;
        let is_event = matches!(access, "inputOnly" | "outputOnly");
        let has_value = match declares {
            Declares::Nothing => false,
            Declares::Value => !is_event,
            Declares::Either => !is_event || self.lexer.next.text == "IS",
        };
        let value = has_value.then(|| self.value(name)).transpose()?;
        Ok(Declared { access, ty, name, value })
    }
}

/// Values of declared fields.
#[derive(Clone, Copy)]
enum Declares {
    /// EXTERNPROTO: none has one.
    Nothing,
    /// PROTO: those that are not events have one.
    Value,
    /// A script: the same, and each may have an IS.
    Either,
}
