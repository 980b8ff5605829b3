//! Whatever bytes come in, a model or an error comes out, and never another model.

use super::*;
use crate::samples::{empty, rectangle, small, tangles, view};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng};
use transect_geometry::Curve;

fn bytes_of(model: &Model) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(model, &mut bytes).unwrap();
    bytes
}

/// A file with a right header around any payload.
fn file_around(payload: &[u8]) -> Vec<u8> {
    let length = (payload.len() as u64).to_le_bytes();
    let version = SCHEMA_VERSION.to_le_bytes();
    [&MAGIC[..], &version, &length, &fnv1a(payload).to_le_bytes(), payload].concat()
}

/// The same mutations in every run, so that a failure can be repeated.
fn random() -> TestRng {
    TestRng::deterministic_rng(RngAlgorithm::ChaCha)
}

proptest! {
    #[test]
    fn going_there_and_back_returns_the_model(
        planes in prop::collection::vec((any::<i64>(), tangles()), 0..6), name in ".*",
    ) {
        let mut model = empty();
        for (k, curves) in planes {
            model.set_curves(PlaneIndex(k), curves);
        }
        model.add_view(view(&name));
        model.add_view(ViewRecord { sigma: None, ..view("") });
        let bytes = bytes_of(&model);
        prop_assert_eq!(&read(&bytes[..]).unwrap(), &model);
        prop_assert_eq!(bytes_of(&model), bytes);
    }
}

#[test]
fn world_sized_coordinates_keep_every_bit() {
    let mut model = empty();
    let (x, y) = (500_000.000_001, 5_400_000.000_001);
    model.set_curves(PlaneIndex(i64::MIN), vec![rectangle(x, y, x + 1e-6, y + 1e-6)]);
    assert_eq!(read(&bytes_of(&model)[..]).unwrap(), model);
}

#[test]
fn the_hash_is_the_published_one() {
    // Test vectors of the authors.
    assert_eq!(fnv1a(b""), 0xcbf2_9ce4_8422_2325);
    assert_eq!(fnv1a(b"foobar"), 0x8594_4171_f739_67e8);
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    let bytes = bytes_of(&small());
    for length in 0..bytes.len() {
        let error = read(&bytes[..length]).unwrap_err();
        let expected = if length == 0 {
            matches!(error, CodecError::NotAModel)
        } else {
            matches!(error, CodecError::Truncated { found, .. } if found == length as u64)
        };
        assert!(expected, "{length} bytes: {error}");
    }
}

#[test]
fn every_changed_byte_is_noticed() {
    let bytes = bytes_of(&small());
    for place in 0..bytes.len() {
        for bit in 0..8 {
            let mut changed = bytes.clone();
            changed[place] ^= 1 << bit;
            assert!(read(&changed[..]).is_err(), "byte {place}, bit {bit}");
        }
    }
}

/// Overwrites, inserts, deletes and repeats up to eight stretches of bytes.
fn mutate(bytes: &mut Vec<u8>, rng: &mut TestRng) {
    for _ in 0..rng.random_range(1..=8) {
        let place = rng.random_range(0..bytes.len());
        let end = (place + rng.random_range(0..8)).min(bytes.len());
        match rng.random_range(0..4) {
            0 => bytes[place] = rng.random_range(0..=255) as u8,
            1 => bytes.insert(place, rng.random_range(0..=255) as u8),
            2 if bytes.len() > 16 => drop(bytes.drain(place..end)),
            _ => {
                let stretch = bytes[place..end].to_vec();
                bytes.splice(place..place, stretch);
            }
        }
    }
}

#[test]
fn mutated_files_never_load_as_another_model() {
    let (model, mut rng) = (small(), random());
    let bytes = bytes_of(&model);
    for _ in 0..10_000 {
        let mut changed = bytes.clone();
        mutate(&mut changed, &mut rng);
        if let Ok(loaded) = read(&changed[..]) {
            assert_eq!((&changed, &loaded), (&bytes, &model));
        }
    }
}

#[test]
fn mutated_payloads_with_a_right_checksum_load_as_sound_models_or_not_at_all() {
    let (payload, mut rng) = (values::encode(&Payload::of(&small())).unwrap(), random());
    let mut loaded = 0;
    for _ in 0..10_000 {
        let mut changed = payload.clone();
        mutate(&mut changed, &mut rng);
        if let Ok(model) = read(&file_around(&changed)[..]) {
            assert_eq!(model.check(), Ok(()));
            // Sound means usable: these would panic on a malformed curve.
            let _ = (model.length(), model.locate(&transect_geometry::Point3::origin()));
            loaded += 1;
        }
    }
    assert!(loaded > 0, "the mutations never reach past the decoder");
}

#[test]
fn lengths_beyond_the_file_set_no_memory_aside() {
    let mut announced = file_around(b"");
    announced[12..20].copy_from_slice(&u64::MAX.to_le_bytes());
    assert!(matches!(read(&announced[..]), Err(CodecError::Truncated { .. })));

    // Unit, the tag of a straight guide, direction, offset and interval of the planes, and the mark
    // of all planes. Then a list of planes or views that claims 2^60 items, or a view's name that
    // claims as many bytes. 253 announces a 64-bit integer.
    let planes = [0.0, 0.0, 1.0, 0.0, 0.5].map(f64::to_le_bytes).concat();
    let wild = [&[253][..], &(1_u64 << 60).to_le_bytes()].concat();
    let after = |begin: &[u8]| [begin, &wild].concat();
    for lists in [after(&[1]), after(&[0]), after(&[0, 1])] {
        let payload = [&[0, 0][..], &planes, &lists].concat();
        assert!(matches!(read(&file_around(&payload)[..]), Err(CodecError::Damaged(_))));
    }
    // The beginning of that payload is right: with empty lists it is a model.
    let sound = [&[0, 0][..], &planes, &[0, 0, 0]].concat();
    assert_eq!(read(&file_around(&sound)[..]).unwrap().curve_count(), 0);
}

#[test]
fn another_version_and_other_files_say_so() {
    let mut newer = bytes_of(&small());
    newer[8] = 9;
    let text = read(&newer[..]).unwrap_err().to_string();
    assert_eq!(
        text,
        "the file has format version 9; version 6 is read here. Open it with the program that \
         wrote it, or with a newer version of this one"
    );
    assert!(matches!(read(&b"{ \"unit\": \"m\" }"[..]), Err(CodecError::NotAModel)));
    let longer = [bytes_of(&small()), vec![0]].concat();
    assert!(matches!(read(&longer[..]), Err(CodecError::Damaged(_))));
}

/// Encodes a payload that no constructor would make.
fn forged(sections: Vec<(PlaneIndex, Section)>) -> Result<Model, CodecError> {
    forged_selection(None, sections)
}

fn forged_selection(
    selected: Option<Vec<i64>>,
    sections: Vec<(PlaneIndex, Section)>,
) -> Result<Model, CodecError> {
    let model = empty();
    let selected = selected.map(|planes| planes.into_iter().map(PlaneIndex).collect());
    let sections = sections.into_iter().map(|(k, s)| (k, Cow::Owned(s))).collect();
    let (unit, planes) = (model.unit(), model.planes().clone());
    let payload = Payload { unit, planes, selected, views: Cow::Borrowed(&[]), sections };
    let bytes = bincode::serde::encode_to_vec(&payload, bincode::config::standard()).unwrap();
    read(&file_around(&bytes)[..])
}

#[test]
fn the_planes_that_were_asked_for_are_kept_and_checked() {
    let model = small().with_selection([-3, 7, 9].map(PlaneIndex));
    assert_eq!(read(&bytes_of(&model)[..]).unwrap(), model);
    let section =
        || vec![(PlaneIndex(4), Section::new(vec![rectangle(0.0, 0.0, 1.0, 1.0)]).unwrap())];
    assert!(forged_selection(Some(vec![3, 4]), section()).is_ok());
    for (selected, error) in [
        (vec![3, 5], InvariantError::NotSelected(PlaneIndex(4))),
        (vec![4, 4], InvariantError::PlaneOutOfOrder(PlaneIndex(4))),
        (vec![5, 4], InvariantError::PlaneOutOfOrder(PlaneIndex(4))),
    ] {
        match forged_selection(Some(selected), section()) {
            Err(CodecError::Invariant(found)) => assert_eq!(found, error),
            other => panic!("not refused as unsound: {other:?}"),
        }
    }
}

fn broken(sections: Vec<(PlaneIndex, Section)>) -> InvariantError {
    match forged(sections) {
        Err(CodecError::Invariant(error)) => error,
        other => panic!("not refused as unsound: {other:?}"),
    }
}

/// Serialises one thing and reads it as another of the same layout, past the constructors.
fn recast<T: Serialize, U: serde::de::DeserializeOwned>(value: &T) -> U {
    let config = bincode::config::standard();
    let bytes = bincode::serde::encode_to_vec(value, config).unwrap();
    bincode::serde::decode_from_slice(&bytes, config).unwrap().0
}

#[test]
fn broken_invariants_in_a_file_are_found() {
    let square = || Section::new(vec![rectangle(0.0, 0.0, 1.0, 1.0)]).unwrap();
    let (envelope, curve) = (square().envelope(), rectangle(0.0, 0.0, 1.0, 1.0));
    assert!(forged(vec![(PlaneIndex(0), square()), (PlaneIndex(1), square())]).is_ok());

    let swapped = vec![(PlaneIndex(1), square()), (PlaneIndex(0), square())];
    assert_eq!(broken(swapped), InvariantError::PlaneOutOfOrder(PlaneIndex(0)));
    let twice = vec![(PlaneIndex(1), square()), (PlaneIndex(1), square())];
    assert_eq!(broken(twice), InvariantError::PlaneOutOfOrder(PlaneIndex(1)));

    let no_curves: Section = recast(&(envelope, Vec::<Curve>::new()));
    assert_eq!(
        broken(vec![(PlaneIndex(2), no_curves)]),
        InvariantError::EmptySection(PlaneIndex(2))
    );
    let wide: Section = recast(&(envelope.grown(1.0), vec![(envelope, curve.clone())]));
    assert_eq!(broken(vec![(PlaneIndex(2), wide)]), InvariantError::PlaneEnvelope(PlaneIndex(2)));
    let wide: Section = recast(&(envelope.grown(1.0), vec![(envelope.grown(1.0), curve)]));
    assert!(matches!(broken(vec![(PlaneIndex(2), wide)]), InvariantError::CurveEnvelope { .. }));
}

#[test]
fn a_curve_without_nodes_cannot_even_be_decoded() {
    let envelope = rectangle(0.0, 0.0, 1.0, 1.0).envelope();
    let nodes: Vec<transect_geometry::Node> = Vec::new();
    let config = bincode::config::standard();
    let ends = [None::<transect_geometry::EndReason>; 2];
    let section = (envelope, vec![(envelope, (nodes, true, ends))]);
    let bytes = bincode::serde::encode_to_vec(&section, config).unwrap();
    let refused = bincode::serde::decode_from_slice::<Section, _>(&bytes, config).unwrap_err();
    assert!(refused.to_string().contains("0 nodes cannot make a closed curve"), "{refused}");
}

#[test]
fn a_curved_guide_comes_back_with_its_frames() {
    use transect_geometry::{CurvedGuide, GuideKind, Point3};
    let points = [(0.0, 0.0, 0.0), (9.0, 1.0, 0.0), (15.0, 8.0, 2.0), (15.0, 20.0, 2.5)];
    let points: Vec<_> = points.map(|(x, y, z)| Point3::new(x, y, z)).to_vec();
    let kinds = [GuideKind::Spline, GuideKind::Polyline(None), GuideKind::Polyline(Some(2.0))];
    for guide in kinds.map(|kind| CurvedGuide::new(kind, points.clone()).unwrap()) {
        let planes = PlaneFamily::new(guide, 0.3, 0.5).unwrap();
        let mut model = Model::new(LengthUnit::Metre, planes.clone());
        model.set_curves(PlaneIndex(11), vec![rectangle(0.0, 0.0, 1.0, 2.0)]);
        let back = read(&bytes_of(&model)[..]).unwrap();
        assert_eq!(back, model);
        assert_eq!(back.planes().frame(PlaneIndex(11)), planes.frame(PlaneIndex(11)));
    }
}

#[test]
fn a_guide_that_is_none_is_refused() {
    // Unit, then the tags of a curved guide and of a spline, and a single point.
    let planes = [0.0, 0.0, 1.0, 0.0, 0.5].map(f64::to_le_bytes).concat();
    let bytes = file_around(&[&[0, 1, 1, 1][..], &planes, &[0, 0]].concat());
    let error = read(&bytes[..]).unwrap_err().to_string();
    assert!(error.contains("a guide has 1 points"), "{error}");
}
