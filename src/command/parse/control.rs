//! Parsers of queries, frames and connection settings.

use super::{Parsed, switch};
use crate::command::args::Args;
use crate::command::commands::{Command, ErrorMode, SnapTarget};

pub fn help(_: &mut Args<'_>) -> Parsed {
    Ok(Command::Help)
}

pub fn size(_: &mut Args<'_>) -> Parsed {
    Ok(Command::Size)
}

pub fn stats(_: &mut Args<'_>) -> Parsed {
    Ok(Command::Stats)
}

pub fn quit(_: &mut Args<'_>) -> Parsed {
    Ok(Command::Quit)
}

pub fn depthat(args: &mut Args<'_>) -> Parsed {
    let [x, y] = args.ints()?;
    Ok(Command::DepthAt { x, y })
}

pub fn pick(args: &mut Args<'_>) -> Parsed {
    let [x, y] = args.ints()?;
    Ok(Command::Pick { x, y })
}

pub fn sync(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Sync { tag: args.name()? })
}

pub fn hello(_: &mut Args<'_>) -> Parsed {
    Ok(Command::Hello)
}

pub fn version(_: &mut Args<'_>) -> Parsed {
    Ok(Command::Version)
}

pub fn auto(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Auto(switch(args)?))
}

pub fn present(args: &mut Args<'_>) -> Parsed {
    let wait = args.left() > 0;
    if wait {
        args.keyword("wait", |word| word.eq_ignore_ascii_case("wait").then_some(()))?;
    }
    Ok(Command::Present { wait })
}

pub fn events(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Events(switch(args)?))
}

pub fn errors(args: &mut Args<'_>) -> Parsed {
    let mode = args.keyword("count, report or close", |word| match word.to_ascii_lowercase().as_str() {
        "count" => Some(ErrorMode::Count),
        "report" => Some(ErrorMode::Report),
        "close" => Some(ErrorMode::Close),
        _ => None,
    })?;
    Ok(Command::Errors(mode))
}

pub fn snap(args: &mut Args<'_>) -> Parsed {
    let name = args.name()?;
    Ok(Command::Snap(if name == ":" { SnapTarget::Connection } else { SnapTarget::File(name) }))
}
