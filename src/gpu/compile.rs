//! From GLSL to SPIR-V by the shaderc library: kernels given at run time are compiled with the options of the built-in
//! ones. The build script includes this file where it builds shaderc itself.

/// Compiles one shader, optimised to a level and with a macro defined, if there is one; a warning is an error, and
/// messages name file and line. `include` finds a file by the name in the `#include`, and returns the name for messages
/// and the text.
pub fn compile(
    compiler: &shaderc::Compiler,
    source: &str,
    name: &str,
    (level, define): (shaderc::OptimizationLevel, Option<&str>),
    include: impl Fn(&str) -> Result<(String, String), String>,
) -> Result<shaderc::CompilationArtifact, String> {
    let mut options = shaderc::CompileOptions::new().map_err(|e| e.to_string())?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_2 as u32);
    options.set_target_spirv(shaderc::SpirvVersion::V1_5);
    options.set_optimization_level(level);
    options.set_generate_debug_info();
    if let Some(define) = define {
        options.add_macro_definition(define, None);
    }
    options.set_warnings_as_errors();
    options.set_include_callback(|name, _, _, _| {
        include(name).map(|(resolved_name, content)| shaderc::ResolvedInclude { resolved_name, content })
    });
    compiler.compile_into_spirv(source, shaderc::ShaderKind::Compute, name, "main", Some(&options)).map_err(|error| {
        match error {
            shaderc::Error::CompilationError(_, text) => text.trim_end().to_string(),
            other => other.to_string(),
        }
    })
}
