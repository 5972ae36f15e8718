// Parameters of the cloth as the host, or `minimise`, wrote them before the dispatch.

@group(0) @binding(0) var<uniform> stage: ClothStage;
