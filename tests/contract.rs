//! The contract between shaders and host, which needs no device: files, structs, bindings and numbers that both write down.

use std::collections::BTreeSet;

use libtest_mimic::Trial;
use ripstop::gpu::adapters::STORAGE_BUFFERS_NEEDED;
use ripstop::gpu::pipeline::{bindings, validate};
use ripstop::gpu::{layouts, shaders};
use ripstop::lattice::Operator;

use crate::command_line::root;
use crate::engines::plain;

pub fn trials() -> Vec<Trial> {
    [
        plain("contract::no_orphan_shader", orphans),
        plain("contract::every_shader_validates", every_shader),
        plain("contract::structs_match_by_offset", structs),
        plain("contract::the_readme_names_all", told),
        plain("contract::operators_match_by_number", operators),
        plain("contract::bindings_match_by_name", names),
        plain("contract::adapters_are_asked_for_enough", storage_buffers),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The README of `shaders/` names every shader.
fn told() {
    let readme = std::fs::read_to_string(root().join("shaders/README.md")).unwrap();
    for shader in shaders::all() {
        let name = shader
            .name
            .trim_end_matches("_f32")
            .trim_end_matches("_f16");
        assert!(readme.contains(&format!("`{name}`")), "{name}");
    }
}

fn orphans() {
    let registered: BTreeSet<&str> = shaders::all()
        .iter()
        .flat_map(|shader| shader.parts.iter().map(|(file, _)| *file))
        .collect();
    let mut found = 0;
    for entry in std::fs::read_dir(root().join("shaders")).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        if name.ends_with(".wgsl") {
            found += 1;
            assert!(
                registered.contains(name.as_str()),
                "{name} belongs to no shader"
            );
        }
    }
    assert_eq!(
        found,
        registered.len(),
        "a registered file is not in shaders/"
    );
}

fn every_shader() {
    for shader in &shaders::all() {
        let (module, info) = validate(shader).unwrap_or_else(|e| panic!("{}: {e}", shader.name));
        assert!(
            !module.entry_points.is_empty(),
            "{} does nothing",
            shader.name
        );
        // Every constant has a value from the start, so that a pipeline without that choice can be built.
        let (module, _) = naga::back::pipeline_constants::process_overrides(
            &module,
            &info,
            None,
            &Default::default(),
        )
        .unwrap_or_else(|e| panic!("{}: {e}", shader.name));
        for point in &module.entry_points {
            if point.stage == naga::ShaderStage::Compute {
                assert_eq!(
                    point.workgroup_size,
                    [ripstop::gpu::shaders::WORKGROUP, 1, 1],
                    "{}::{}",
                    shader.name,
                    point.name
                );
            }
        }
    }
}

/// Every operator has a constant of its name and a case of its number in every shader that collides, and no shader has others.
fn operators() {
    let mut seen = 0;
    for shader in &shaders::all() {
        let (module, _) = validate(shader).unwrap();
        let mut functions = module.functions.iter().map(|(_, function)| function);
        let Some(collide) = functions.find(|f| f.name.as_deref() == Some("collide")) else {
            continue;
        };
        seen += 1;
        for operator in Operator::ALL {
            let name = operator.name().to_uppercase();
            let mut constants = module.constants.iter().map(|(_, constant)| constant);
            let constant = constants.find(|c| c.name.as_deref() == Some(&name));
            let constant = constant.unwrap_or_else(|| panic!("{}: no {name}", shader.name));
            assert_eq!(
                module.global_expressions[constant.init],
                naga::Expression::Literal(naga::Literal::U32(operator.number())),
                "{name} in {}",
                shader.name
            );
        }
        let cases = collide.body.iter().find_map(|statement| match statement {
            naga::Statement::Switch { cases, .. } => Some(cases),
            _ => None,
        });
        let cases: Vec<naga::SwitchValue> = cases
            .unwrap()
            .iter()
            .map(|case| {
                assert!(!case.fall_through, "{}: {:?}", shader.name, case.value);
                case.value
            })
            .collect();
        let mut expected = Operator::ALL
            .map(|o| naga::SwitchValue::U32(o.number()))
            .to_vec();
        expected.push(naga::SwitchValue::Default);
        assert_eq!(cases, expected, "{}", shader.name);
    }
    assert!(seen > 0);
}

/// Structs of the same name have the same fields at the same offsets, in Rust and in every shader.
fn structs() {
    let layouts = layouts::all();
    let mut seen = BTreeSet::new();
    for shader in &shaders::all() {
        let (module, _) = validate(shader).unwrap();
        for (_, kind) in module.types.iter() {
            let (Some(name), naga::TypeInner::Struct { members, span }) = (&kind.name, &kind.inner)
            else {
                continue;
            };
            let Some(layout) = layouts.iter().find(|layout| layout.name == name) else {
                continue;
            };
            seen.insert(layout.name);
            assert_eq!(
                *span as usize, layout.size,
                "size of {name} in {}",
                shader.name
            );
            let fields: Vec<(&str, usize)> = members
                .iter()
                .map(|m| (m.name.as_deref().unwrap(), m.offset as usize))
                .collect();
            assert_eq!(fields, layout.fields, "{name} in {}", shader.name);
        }
        // What the host writes or reads must be declared on its side too.
        for (_, variable) in module.global_variables.iter() {
            let kind = &module.types[variable.ty];
            let element = match kind.inner {
                naga::TypeInner::Array { base, .. } => &module.types[base],
                _ => kind,
            };
            if let (naga::TypeInner::Struct { .. }, Some(name), Some(_)) =
                (&element.inner, &element.name, &variable.binding)
            {
                assert!(
                    layouts.iter().any(|layout| layout.name == name),
                    "{name} in {} is unknown to Rust",
                    shader.name
                );
            }
        }
    }
    for layout in layouts {
        assert!(seen.contains(layout.name), "no shader has {}", layout.name);
    }
}

/// Names of buffers are written in both languages; each must know all of the other's.
fn names() {
    let mut host = String::new();
    let mut files = Vec::new();
    crate::architecture::sources(&root().join("src/gpu"), &mut files);
    for file in files {
        host.push_str(&std::fs::read_to_string(file).unwrap());
    }
    let (mut declared, mut used) = (BTreeSet::new(), BTreeSet::new());
    for shader in &shaders::all() {
        let (module, info) = validate(shader).unwrap();
        for point in &module.entry_points {
            if point.stage != naga::ShaderStage::Compute {
                // Pictures are bound by number, in one place; a mistake there shows.
                let names = bindings(&module, &info, &point.name).into_iter();
                used.extend(names.map(|(name, _)| name));
                continue;
            }
            for (name, _) in bindings(&module, &info, &point.name) {
                assert!(
                    host.contains(&format!("\"{name}\"")),
                    "{}: the host gives no buffer for {name}",
                    shader.name
                );
                used.insert(name);
            }
            // Of the fabric's elements the host writes kind and what is asked of it apart.
            let name = point.name.as_str();
            let quoted = |part: &str| host.contains(&format!("\"{part}\""));
            let parts = name.rsplit_once('_');
            assert!(
                quoted(name) || parts.is_some_and(|(kind, what)| quoted(kind) && quoted(what)),
                "no pipeline is made of {name}"
            );
        }
        declared.extend(
            module
                .global_variables
                .iter()
                .filter(|(_, v)| v.binding.is_some())
                .filter_map(|(_, v)| v.name.clone()),
        );
    }
    // Parts shared by two shaders may declare what only one of them uses.
    assert_eq!(declared, used, "bindings that nothing uses");
}

/// What an adapter must offer is what the widest entry point takes.
fn storage_buffers() {
    let mut widest = 0;
    // That of small fabric holds every kind of element; a structure has few, and those that a device cannot hold at once are solved in batches.
    let whole = |shader: &&shaders::Shader| shader.name != shaders::SMALL_CLOTH.name;
    for shader in shaders::all().iter().filter(whole) {
        let (module, info) = validate(shader).unwrap();
        for (index, point) in module.entry_points.iter().enumerate() {
            let uses = info.get_entry_point(index);
            let storage = module.global_variables.iter().filter(|(handle, v)| {
                !uses[*handle].is_empty()
                    && matches!(v.space, naga::AddressSpace::Storage { .. })
                    && v.binding.is_some()
            });
            let count = storage.count() as u32;
            assert!(
                count <= STORAGE_BUFFERS_NEEDED,
                "{} takes {count} storage buffers",
                point.name
            );
            widest = widest.max(count);
        }
    }
    assert_eq!(widest, STORAGE_BUFFERS_NEEDED);
}
