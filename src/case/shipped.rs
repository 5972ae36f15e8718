//! Shipped cases, embedded so that an installed binary can write them.

/// Shipped cases, embedded so that an installed binary can print them: name, text.
pub const SHIPPED: [(&str, &str); 27] = [
    ("airbag", include_str!("../../cases/cloth/airbag.toml")),
    (
        "bias-extension",
        include_str!("../../cases/cloth/bias-extension.toml"),
    ),
    (
        "cruciform",
        include_str!("../../cases/designs/cruciform.toml"),
    ),
    (
        "disk-gap-band",
        include_str!("../../cases/disk-gap-band.toml"),
    ),
    (
        "finite-mass-drop",
        include_str!("../../cases/finite-mass-drop.toml"),
    ),
    (
        "hemispherical-mesh",
        include_str!("../../cases/hemispherical-mesh.toml"),
    ),
    (
        "hencky-disc",
        include_str!("../../cases/cloth/hencky-disc.toml"),
    ),
    (
        "flat-circular-tunnel",
        include_str!("../../cases/flat-circular-tunnel.toml"),
    ),
    ("flag", include_str!("../../cases/flag.toml")),
    (
        "flexible-plate",
        include_str!("../../cases/flexible-plate.toml"),
    ),
    (
        "folded-gore",
        include_str!("../../cases/cloth/folded-gore.toml"),
    ),
    (
        "hanging-sheet",
        include_str!("../../cases/cloth/hanging-sheet.toml"),
    ),
    (
        "hanging-chain",
        include_str!("../../cases/cloth/hanging-chain.toml"),
    ),
    (
        "parafoil-brake",
        include_str!("../../cases/parafoil-brake.toml"),
    ),
    (
        "ram-air-parachute",
        include_str!("../../cases/ram-air-parachute.toml"),
    ),
    (
        "slung-weight",
        include_str!("../../cases/cloth/slung-weight.toml"),
    ),
    (
        "shaken-rope",
        include_str!("../../cases/cloth/shaken-rope.toml"),
    ),
    (
        "slotted-drop",
        include_str!("../../cases/slotted-drop.toml"),
    ),
    (
        "mesh-in-a-stream",
        include_str!("../../cases/mesh-in-a-stream.toml"),
    ),
    (
        "paraglider",
        include_str!("../../cases/designs/paraglider.toml"),
    ),
    (
        "personnel-descent",
        include_str!("../../cases/designs/personnel-descent.toml"),
    ),
    (
        "ringslot-drop",
        include_str!("../../cases/designs/ringslot-drop.toml"),
    ),
    ("sphere", include_str!("../../cases/sphere.toml")),
    (
        "tapered-wing",
        include_str!("../../cases/tapered-wing.toml"),
    ),
    (
        "taylor-green",
        include_str!("../../cases/taylor-green.toml"),
    ),
    ("wing-27", include_str!("../../cases/wing-27.toml")),
    ("wing-school", include_str!("../../cases/wing-school.toml")),
];

/// Files that shipped cases name: the case, the path beside it, the text.
pub const SHIPPED_FILES: [(&str, &str, &str); 4] = [
    (
        "hemispherical-mesh",
        "meshes/hemisphere.obj",
        include_str!("../../cases/meshes/hemisphere.obj"),
    ),
    (
        "hemispherical-mesh",
        "meshes/hemisphere-lines.csv",
        include_str!("../../cases/meshes/hemisphere-lines.csv"),
    ),
    (
        "mesh-in-a-stream",
        "meshes/hemisphere.obj",
        include_str!("../../cases/meshes/hemisphere.obj"),
    ),
    (
        "mesh-in-a-stream",
        "meshes/hemisphere-lines.csv",
        include_str!("../../cases/meshes/hemisphere-lines.csv"),
    ),
];
