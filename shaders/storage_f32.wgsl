// How populations lie in memory: as they are computed.

alias Stored = f32;

fn unpacked(value: Stored) -> f32 {
    return value;
}

fn packed(value: f32) -> Stored {
    return value;
}
