//! Constants, records and buffers as GLSL: what shaders include as `layout.glsl`.

use std::fmt::Write as _;

/// The text of `layout.glsl`.
pub fn declarations() -> String {
    let mut text = String::from(
        "#ifndef LAYOUT\n#define LAYOUT\n#extension GL_EXT_scalar_block_layout : require\n\
         #extension GL_EXT_control_flow_attributes : require\n\
         #define READS(name) READS_##name\n#define WRITES(name) WRITES_##name\n#define UPDATES(name) UPDATES_##name\n\
         #define SHARES(name) SHARES_##name\n",
    );
    for constant in super::numbers().into_iter().chain(super::kinds()) {
        let _ = writeln!(text, "const {} {} = {};", constant.kind, constant.name, constant.value);
    }
    for record in super::records() {
        let _ = write!(text, "struct {} {{", record.name);
        for (field, kind, _) in &record.fields {
            let _ = write!(text, " {kind} {field};");
        }
        text.push_str(" };\n");
    }
    for &id in super::BUFFER_IDS {
        let (spec, binding) = (id.spec(), id as usize);
        for (word, qualifier) in
            [("READS", "readonly"), ("WRITES", "writeonly"), ("UPDATES", ""), ("SHARES", "coherent")]
        {
            let _ = writeln!(
                text,
                "#define {word}_{name} layout(set = 0, binding = {binding}, scalar) restrict {qualifier} \
                 buffer {name}_block {{ {kind} {name}[]; }};",
                name = spec.name,
                kind = spec.glsl,
            );
        }
    }
    text.push_str("#endif\n");
    text
}
