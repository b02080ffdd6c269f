//! A strict reader of the part of AmberScript that the program writes, after the format's documentation.

use std::collections::BTreeMap;
use std::path::Path;

/// What a script declares and does.
#[derive(Default)]
pub struct Script {
    /// Buffers: type and number of items.
    pub buffers: BTreeMap<String, (String, usize)>,
    pub pipelines: Vec<String>,
    pub runs: Vec<(String, [u32; 3])>,
    /// Comparisons.
    pub expectations: usize,
    /// How long a run may take, milliseconds.
    pub fence: Option<u32>,
}

/// Reads the script `case.amber` of a folder; panics at the first line that the grammar does not allow.
pub fn read(folder: &Path) -> Script {
    let text = std::fs::read_to_string(folder.join("case.amber")).unwrap();
    check(&text, folder).unwrap_or_else(|fault| panic!("{}: {fault}", folder.display()))
}

fn number<T: std::str::FromStr>(word: Option<&&str>) -> Result<T, String> {
    let word = word.ok_or("a number is missing")?;
    if word.starts_with('+') || word.is_empty() {
        return Err(format!("{word} is no number"));
    }
    word.parse().map_err(|_| format!("{word} is no number of its kind"))
}

/// A float must have a point: without one it is an integer.
fn float(word: Option<&&str>) -> Result<f64, String> {
    let value: f64 = number(word)?;
    if !word.unwrap().contains('.') || !value.is_finite() { Err(format!("{word:?} is no float")) } else { Ok(value) }
}

fn name(word: Option<&&str>) -> Result<String, String> {
    let word = *word.ok_or("a name is missing")?;
    let plain = word.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    // A word that begins like a number is read as one.
    let first = word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if plain && first { Ok(word.into()) } else { Err(format!("{word} is no name")) }
}

pub fn check(text: &str, folder: &Path) -> Result<Script, String> {
    let mut lines = text.lines().enumerate();
    if lines.next().map(|(_, line)| line) != Some("#!amber") {
        return Err("the first line is not #!amber".into());
    }
    let mut reader = Reader { folder, script: Script::default(), shaders: Vec::new(), data: None, open: None };
    for (at, line) in lines {
        let code = line.split('#').next().unwrap();
        let words: Vec<&str> = code.split_whitespace().collect();
        let taken = match () {
            () if words.is_empty() => Ok(()),
            () if reader.data.is_some() => reader.data(&words),
            () if reader.open.is_some() => reader.pipeline(&words),
            () => reader.command(&words),
        };
        taken.map_err(|fault| format!("line {}: {fault}: {line}", at + 1))?;
    }
    let Reader { script, data, open, .. } = reader;
    // What is to end at all needs no comparison.
    let nothing = script.expectations == 0 && script.fence.is_none();
    match (data.is_none() && open.is_none(), script.runs.is_empty() || nothing) {
        (false, _) => Err("an END is missing".into()),
        (_, true) => Err("nothing is run, or nothing compared".into()),
        _ => Ok(script),
    }
}

/// What is known after some lines.
struct Reader<'a> {
    folder: &'a Path,
    script: Script,
    shaders: Vec<String>,
    /// Items so far of a buffer whose data are being listed.
    data: Option<usize>,
    /// Whether a shader is attached to the pipeline being declared, and its bindings.
    open: Option<(bool, Vec<u32>)>,
}

impl Reader<'_> {
    fn data(&mut self, words: &[&str]) -> Result<(), String> {
        let mut count = self.data.take().unwrap();
        if words == ["END"] {
            self.script.buffers.values_mut().filter(|b| b.1 == usize::MAX).for_each(|b| b.1 = count);
            return if count > 0 { Ok(()) } else { Err("no data".into()) };
        }
        for word in words {
            number::<u32>(Some(word))?;
            count += 1;
        }
        self.data = Some(count);
        Ok(())
    }

    fn pipeline(&mut self, words: &[&str]) -> Result<(), String> {
        let (attached, bound) = self.open.as_mut().unwrap();
        match words[..] {
            ["END"] if *attached => self.open = None,
            ["ATTACH", shader, ref rest @ ..] if !*attached => {
                *attached = true;
                if !self.shaders.contains(&shader.to_string()) || !rest.len().is_multiple_of(5) {
                    return Err("what is attached".into());
                }
                specialized(rest)?;
            }
            ["BIND", "BUFFER", buffer, "AS", "push_constant"] => {
                let known = self.script.buffers.get(buffer).ok_or("the buffer is not declared")?;
                if !*attached || known.0 != "uint32" {
                    return Err("push constants".into());
                }
            }
            ["BIND", "BUFFER", buffer, "AS", "storage", "DESCRIPTOR_SET", "0", "BINDING", ref rest @ ..] => {
                let own = number::<u32>(rest.first())?;
                let known = self.script.buffers.get(buffer).ok_or("the buffer is not declared")?;
                if !*attached || bound.contains(&own) {
                    return Err("bound twice, or before ATTACH".into());
                }
                bound.push(own);
                match rest[1..] {
                    [] => {}
                    ["DESCRIPTOR_RANGE", range] if number::<usize>(Some(&range))? < 4 * known.1 => {}
                    _ => return Err("what follows BINDING".into()),
                }
            }
            _ => return Err("not a line of a pipeline".into()),
        }
        Ok(())
    }

    fn command(&mut self, words: &[&str]) -> Result<(), String> {
        match words[..] {
            ["SHADER", "compute", shader, "SPIRV-BIN", "FILE", file] => {
                let bytes = std::fs::read(self.folder.join(file)).map_err(|e| e.to_string())?;
                if bytes.get(..4) != Some(&0x0723_0203u32.to_le_bytes()[..]) {
                    return Err("no SPIR-V".into());
                }
                self.shaders.push(name(Some(&shader))?);
            }
            ["BUFFER", buffer, "DATA_TYPE", kind, ref rest @ ..] => self.buffer(buffer, kind, rest)?,
            ["PIPELINE", "compute", pipeline] => {
                self.script.pipelines.push(name(Some(&pipeline))?);
                self.open = Some((false, Vec::new()));
            }
            ["SET", "ENGINE_DATA", "fence_timeout_ms", time] => {
                if self.script.fence.replace(number::<u32>(Some(&time))?).is_some() {
                    return Err("set twice".into());
                }
            }
            ["RUN", pipeline, ref groups @ ..] if groups.len() == 3 => {
                if !self.script.pipelines.iter().any(|known| known == pipeline) {
                    return Err("no such pipeline".into());
                }
                let groups = [0, 1, 2].map(|k| number::<u32>(groups.get(k)).unwrap_or(0));
                if groups.contains(&0) {
                    return Err("groups".into());
                }
                self.script.runs.push((pipeline.into(), groups));
            }
            ["EXPECT", left, "EQ_BUFFER", right] => {
                if !self.script.buffers.contains_key(left)
                    || self.script.buffers.get(left) != self.script.buffers.get(right)
                {
                    return Err("other buffers".into());
                }
                self.script.expectations += 1;
            }
            ["EXPECT", buffer, "IDX", index, ref rest @ ..] => self.expect(buffer, index, rest)?,
            _ => return Err("not a command".into()),
        }
        Ok(())
    }

    fn buffer(&mut self, buffer: &str, kind: &str, rest: &[&str]) -> Result<(), String> {
        let buffer = name(Some(&buffer))?;
        let count = match *rest {
            ["DATA"] => {
                self.data = Some(0);
                usize::MAX
            }
            ["SIZE", count, "FILE", "BINARY", file] => {
                let size = std::fs::metadata(self.folder.join(file)).map_err(|e| e.to_string())?.len();
                let count: usize = number(Some(&count))?;
                if count == 0 || size != 4 * count as u64 {
                    return Err(format!("{file} has {size} bytes"));
                }
                count
            }
            _ => return Err("an initializer".into()),
        };
        if !["uint32", "float"].contains(&kind) || self.script.buffers.insert(buffer, (kind.into(), count)).is_some() {
            return Err("type, or declared twice".into());
        }
        Ok(())
    }

    fn expect(&mut self, buffer: &str, index: &str, rest: &[&str]) -> Result<(), String> {
        let known = self.script.buffers.get(buffer).ok_or("the buffer is not declared")?;
        let index: usize = number(Some(&index))?;
        let values = match *rest {
            ["EQ", ref values @ ..] if known.0 == "uint32" => {
                values.iter().try_for_each(|value| number::<u32>(Some(value)).map(drop))?;
                values.len()
            }
            ["TOLERANCE", tolerance, "EQ", value] if known.0 == "float" => {
                float(Some(&value))?;
                if float(Some(&tolerance))? < 0.0 {
                    return Err("a negative tolerance".into());
                }
                1
            }
            _ => return Err("a comparison".into()),
        };
        if !index.is_multiple_of(4) || values == 0 || index / 4 + values > known.1 {
            return Err("beyond the buffer".into());
        }
        self.script.expectations += 1;
        Ok(())
    }
}

/// Reads the constants of a shader, which are in order.
fn specialized(words: &[&str]) -> Result<(), String> {
    for (id, special) in words.chunks(5).enumerate() {
        if special[0] != "SPECIALIZE" || special[2] != "AS" || special[3] != "uint32" {
            return Err("SPECIALIZE id AS uint32 value".into());
        }
        if number::<usize>(special.get(1))? != id {
            return Err("constants are not in order".into());
        }
        number::<u32>(special.get(4))?;
    }
    Ok(())
}

#[test]
fn the_reader_is_strict() {
    let here = tempfile::tempdir().unwrap();
    std::fs::write(here.path().join("k.spv"), 0x0723_0203u32.to_le_bytes()).unwrap();
    std::fs::write(here.path().join("a.bin"), [0; 8]).unwrap();
    let good = "#!amber\n# a comment\nSET ENGINE_DATA fence_timeout_ms 9\nSHADER compute k SPIRV-BIN FILE k.spv\n\
                BUFFER a DATA_TYPE uint32 SIZE 2 FILE BINARY a.bin\nBUFFER p DATA_TYPE uint32 DATA\n 1 2\nEND\n\
                PIPELINE compute r\n  ATTACH k SPECIALIZE 0 AS uint32 7\n\
                  BIND BUFFER a AS storage DESCRIPTOR_SET 0 BINDING 3\n  BIND BUFFER p AS push_constant\nEND\n\
                RUN r 1 2 3\nEXPECT a IDX 4 EQ 7\n";
    let script = check(good, here.path()).unwrap();
    assert_eq!((script.runs, script.expectations), (vec![("r".into(), [1, 2, 3])], 1));
    assert_eq!(script.fence, Some(9));
    let idle = good.replace("EXPECT a IDX 4 EQ 7\n", "");
    assert!(check(&idle, here.path()).is_ok());
    assert!(check(&idle.replace("SET ENGINE_DATA fence_timeout_ms 9\n", ""), here.path()).is_err());
    for (old, new) in [
        ("#!amber", "#amber"),
        ("timeout_ms 9", "timeout_ms 9.5"),
        ("ENGINE_DATA ", ""),
        ("SPIRV-BIN", "SPIRV-HEX"),
        ("k.spv", "a.bin"),
        ("SIZE 2", "SIZE 3"),
        ("DATA\n 1 2\nEND", "DATA 1 2 END"),
        ("compute r", "graphics r"),
        ("ATTACH k", "ATTACH l"),
        ("AS uint32 7", "AS uint32 7.5"),
        ("BINDING 3", "BINDING 3 OFFSET 4"),
        ("RUN r 1", "RUN r 0"),
        ("RUN r", "RUN s"),
        ("IDX 4", "IDX 8"),
        ("EQ 7", "TOLERANCE 1.0 EQ 7.0"),
        ("EQ 7", "EQ_BUFFER p"),
        ("RUN r 1 2 3\n", ""),
        ("push_constant\nEND", "push_constant\n"),
    ] {
        assert!(good.contains(old), "{old}");
        assert!(check(&good.replacen(old, new, 1), here.path()).is_err(), "{old} -> {new}");
    }
}
