//! What is wrong with a description is said once, when it is compiled: which part, which number, what was found.

use moreau::{
    Body, ContactCurve, Description, DescriptionPart, Exponent, Fault, Felt, GROUND, Loss, ModelError, Settings, Site,
    SiteInput, Spring, State, StepOutcome, Workspace, Zone, step,
};

const DRY: Body<f64> = Body {
    parent: GROUND,
    pivot: [0.0, 0.0],
    mass: 0.1,
    inertia: 1e-3,
    center_of_mass: [0.1, 0.0],
    dry: 0.01,
    viscous: 0.0,
};

fn felt_on_floor() -> Zone<f64> {
    Zone {
        disc_body: 0,
        center: [0.1, 0.0],
        radius: 0.01,
        curve_body: GROUND,
        curve: ContactCurve::Line { point: [0.0, -0.01], normal: [0.0, 1.0] },
        felt: Felt { stiffness: 1e6, exponent: Exponent::Two, loss: Loss::hunt_crossley(0.3) },
        friction: Some(0.2),
    }
}

fn error(description: &Description<f64>) -> ModelError {
    description.compile::<2, 1>().expect_err("a fault")
}

#[test]
fn every_fault_names_its_part_and_its_number() {
    let (bodies, zone) = ([DRY, Body { parent: 0, ..DRY }], felt_on_floor());
    let sound = Description { bodies: &bodies, zones: &[zone], gravity: 9.81, ..Description::default() };
    assert!(sound.compile::<2, 1>().is_ok());

    assert_eq!(error(&Description { bodies: &[DRY; 3], ..sound }), ModelError::TooManyBodies { found: 3, room: 2 });
    assert_eq!(error(&Description { zones: &[zone; 2], ..sound }), ModelError::TooManyZones { found: 2, room: 1 });
    let child_first = [Body { parent: 1, ..DRY }, DRY];
    assert_eq!(error(&Description { bodies: &child_first, ..sound }), ModelError::ParentOrder { body: 0, parent: 1 });
    let astray = [Zone { disc_body: 7, ..zone }];
    let unknown = ModelError::UnknownBody { part: DescriptionPart::Zone(0), body: 7 };
    assert_eq!(error(&Description { zones: &astray, ..sound }), unknown);

    let number = |description: Description<f64>| match error(&description) {
        ModelError::BadNumber { part, fault: Fault { field, found, .. } } => (part, field, found),
        other => panic!("{other}"),
    };
    let body = |body| number(Description { bodies: &[DRY, body], zones: &[], ..sound });
    assert_eq!(body(Body { mass: -1.0, ..DRY }), (DescriptionPart::Body(1), "mass", -1.0));
    assert_eq!(body(Body { inertia: 0.0, ..DRY }), (DescriptionPart::Body(1), "inertia", 0.0));
    assert_eq!(body(Body { dry: f64::INFINITY, ..DRY }), (DescriptionPart::Body(1), "dry", f64::INFINITY));
    assert_eq!(
        body(Body { center_of_mass: [0.0, f64::INFINITY], ..DRY }),
        (DescriptionPart::Body(1), "center_of_mass", f64::INFINITY)
    );

    let zone = |zone| number(Description { zones: &[zone], ..sound });
    let felt = |loss, exponent| zone(Zone { felt: Felt { stiffness: 1e6, exponent, loss }, ..felt_on_floor() });
    assert_eq!(felt(Loss::quadratic(-1.0), Exponent::Two), (DescriptionPart::Zone(0), "damping", -1.0));
    assert_eq!(felt(Loss::hunt_crossley(-0.1), Exponent::Two), (DescriptionPart::Zone(0), "hunt_crossley", -0.1));
    assert_eq!(felt(Loss::quadratic(0.0), Exponent::Other(0.5)), (DescriptionPart::Zone(0), "exponent", 0.5));
    let slanted = ContactCurve::Line { point: [0.0, 0.0], normal: [0.0, 2.0] };
    assert_eq!(zone(Zone { curve: slanted, ..felt_on_floor() }), (DescriptionPart::Zone(0), "normal", 2.0));
    assert_eq!(zone(Zone { friction: Some(-0.1), ..felt_on_floor() }), (DescriptionPart::Zone(0), "friction", -0.1));

    let spring = Spring { body: 0, torque: 0.0, stiffness: f64::NEG_INFINITY, reference: 0.0 };
    let found = number(Description { springs: &[spring], ..sound });
    assert_eq!(found, (DescriptionPart::Spring(0), "stiffness", f64::NEG_INFINITY));
    let site = Site { body: 0, point: [0.1, 0.0], direction: [0.0, 0.0], stiffness: 1.0, damping: 0.0 };
    assert_eq!(number(Description { site: Some(site), ..sound }), (DescriptionPart::Site, "direction", 0.0));
    let found = number(Description { gravity: f64::INFINITY, ..sound });
    assert_eq!(found, (DescriptionPart::Mechanism, "gravity", f64::INFINITY));

    let said = error(&Description { bodies: &[DRY, Body { mass: -1.0, ..DRY }], ..sound }).to_string();
    assert_eq!(said, "body 1: mass is -1, expected a finite number, at least 0");
}

/// Two dry pivots, a zone with friction and a site are four set-valued laws. With room for three nothing is left out
/// without a word: the workspace is refused, and so is a step with one that was made without asking.
#[test]
fn laws_that_have_no_room_are_an_error() {
    let site = Site { body: 0, point: [0.1, 0.0], direction: [0.0, -1.0], stiffness: 1e3, damping: 0.0 };
    let bodies = [DRY, Body { parent: 0, ..DRY }];
    let zones = [felt_on_floor()];
    let description = Description { bodies: &bodies, zones: &zones, site: Some(site), ..Description::default() };
    assert_eq!(description.laws(), 4);
    let model = description.compile::<2, 1>().unwrap();
    assert_eq!(model.laws(), 4);
    assert!(Workspace::<f64, 2, 1, 4>::for_model(&model).is_ok());
    let refused = Workspace::<f64, 2, 1, 3>::for_model(&model).map(|_| ());
    assert_eq!(refused, Err(ModelError::TooManyLaws { found: 4, room: 3 }));

    let (start, mut workspace) = (State::at_rest([0.3, 0.1]), Workspace::<f64, 2, 1, 3>::new());
    let mut state = start.clone();
    let report = step(&model, &Settings::new(1e-4), &SiteInput::Force(1.0), &mut state, &mut workspace);
    assert_eq!(report.outcome, StepOutcome::TooManyLaws);
    assert!(state.identical(&start));
}
