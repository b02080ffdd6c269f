//! Invariants of the frame: shared lists, sizes, names.

use crate::gpu::{accesses, sources};
use crate::layout::{BUFFER_IDS, BufferId, Partition};
use crate::pipeline::buffer_sizes::grows;
use crate::pipeline::frame::*;
use crate::state::Carrier;

/// Buffers that a stage's kernels bind.
fn bound(stage: &Stage) -> Vec<BufferId> {
    let own = sources().filter(|name| stage.owns(name) && !name.ends_with(".glsl"));
    own.flat_map(|name| accesses(name).unwrap()).map(|access| BUFFER_IDS[access.binding as usize]).collect()
}

/// Buffers that all iterations of a loop share where lists are not kept, but that several of these loops bind.
fn strays(loops: &[&[&'static Stage]]) -> Vec<BufferId> {
    let binds = |id: BufferId| loops.iter().filter(move |stages| stages.iter().any(|stage| bound(stage).contains(&id)));
    let shared = |id: &BufferId| matches!(id.spec().partition, Partition::Chunk | Partition::Batch) || grows(*id);
    BUFFER_IDS.iter().copied().filter(|id| shared(id) && binds(*id).count() > 1).collect()
}

#[test]
fn what_turns_of_a_loop_share_stays_in_that_loop() {
    // Diffusion always keeps its lists: each of its steps reads them again.
    let keeps = |stage: &&Stage| stage.carriers == [Carrier::Diffusion];
    let loops: Vec<Vec<&'static Stage>> =
        parts().map(|part| part.stages().filter(|stage| !keeps(stage)).collect()).collect();
    assert_eq!(strays(&loops.iter().map(Vec::as_slice).collect::<Vec<_>>()), []);

    // A stage of another loop between two that share lists.
    let found = strays(&[&[&link::STAGE], &[&push::STAGE], &[&gather::STAGE]]);
    assert!(found.contains(&BufferId::entries) && found.contains(&BufferId::runs), "{found:?}");
}

/// What conformance does not compare.
#[test]
fn only_its_own_stage_binds_scratch() {
    assert!(STAGES.iter().any(|stage| BUFFER_IDS.iter().any(|id| stage.is_scratch(*id))));
    for stage in STAGES {
        for id in bound(stage) {
            let other = STAGES.iter().find(|other| other.is_scratch(id) && !other.is(stage));
            assert!(other.is_none(), "{} binds {id:?}", stage.name);
        }
    }
}

#[test]
fn every_buffer_has_its_size_from_one_place() {
    for &id in BUFFER_IDS {
        let said = STAGES.iter().filter(|stage| stage.sizes.iter().any(|(sized, _)| *sized == id));
        let said: Vec<&str> = said.map(|stage| stage.name).collect();
        let writers: Vec<&str> = STAGES.iter().filter(|stage| stage.writes(id)).map(|stage| stage.name).collect();
        let queried = QUERIES.iter().any(|stage| stage.writes(id));
        assert!(said.len() <= 1, "{id:?} has its size from {said:?}");
        assert!(said.iter().all(|stage| writers.contains(stage)), "{id:?} is not written by {said:?}");
        let unsized_cut = matches!(id.spec().partition, Partition::Whole | Partition::Chunk | Partition::Batch);
        let input = crate::pipeline::plan::Plan::is_input(id);
        let needed = unsized_cut && !writers.is_empty() && !queried && !input;
        assert!(!needed || said.len() == 1, "none of {writers:?} says how large {id:?} is");
    }
}

#[test]
fn every_stage_has_its_place_once_and_its_name_alone() {
    for stage in STAGES {
        assert_eq!(STAGES.iter().filter(|other| other.is(stage)).count(), 1, "{}", stage.name);
        let query = QUERIES.iter().any(|query| query.is(stage));
        assert_eq!(stage.carriers.is_empty(), query, "{}: who carries the light?", stage.name);
        assert!(!stage.serves.none.is_empty());
        // What is not declared does not compile in STAGES.
        for undeclared in [
            Stage { name: "", ..**stage },
            Stage { module: "", ..**stage },
            Stage { about: "", ..**stage },
            Stage { equation: "", ..**stage },
            Stage { reason: "", ..**stage },
            Stage { writes: &[], ..**stage },
        ] {
            assert!(stage.is_complete() && !undeclared.is_complete());
        }
    }
}

#[test]
fn scopes_are_told_in_words() {
    let at = crate::state::Scope { object: 1, chunk: 2, group: 3 };
    let said = |name: &str, at| crate::state::Step { stage: stage(name).unwrap(), at }.to_string();
    assert_eq!(said(gather::STAGE.name, at), "gather of object 1, channel group 3, batch 2");
    assert_eq!(said(refit::STAGE.name, at), "refit of object 1");
    assert_eq!(said(shade::STAGE.name, crate::state::Scope::SCENE), "shade of the whole scene");
    assert_eq!(said(krylov_step::STAGE.name, at), "krylov_step of object 1, iteration 2");
}
