use super::*;
use crate::test_data::{curve, model, python_with};

/// A round curve and one with a corner.
fn sample() -> Model {
    let at = |k: u32| std::f64::consts::TAU * f64::from(k) / 90.0;
    let ring: Vec<_> =
        (0..90).map(|k| (5e5 + 3.0 * at(k).cos(), 5.4e6 + 2.0 * at(k).sin())).collect();
    let mut hook: Vec<_> = (0..30).map(|k| (f64::from(k) * 0.1, 0.0)).collect();
    hook.extend((0..30).map(|k| (2.9, f64::from(k + 1) * 0.1)));
    model([0.0, 1.0, 0.0], &[(12, vec![curve(&ring, true)]), (-3, vec![curve(&hook, false)])])
}

#[test]
fn the_json_is_the_documented_one() {
    let line = [(0.0, 0.0), (3.0, 0.0)];
    let splines =
        ModelSplines::fit(&model([0.0, 0.0, 1.0], &[(2, vec![curve(&line, false)])]), 0.1);
    let mut text = Vec::new();
    splines.unwrap().write_json(&mut text).unwrap();
    let wanted = concat!(
        "{\"unit\":\"mm\",\"tolerance\":0.1,\"planes\":[\n",
        "{\"index\":2,\"station\":0.5,\"origin\":[0.0,0.0,0.5],\"x_axis\":[1.0,0.0,0.0],",
        "\"y_axis\":[0.0,1.0,0.0],\"curves\":[{\"closed\":false,\"deviation\":0.0,\"pieces\":[",
        "{\"degree\":3,\"knots\":[0.0,0.0,0.0,0.0,3.0,3.0,3.0,3.0],",
        "\"controls\":[[0.0,0.0],[1.0,0.0],[2.0,0.0],[3.0,0.0]]}]}]}\n]}\n"
    );
    assert_eq!(String::from_utf8(text).unwrap(), wanted);
    assert!(ModelSplines::fit(&sample(), 0.0).is_err());
}

#[test]
fn ezdxf_reads_the_splines_back_near_the_nodes() {
    let Some(python) = python_with("ezdxf") else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("splines.dxf");
    // More than the ring's chords are off the ellipse, which a spline need not follow then.
    let (model, tolerance) = (sample(), 4e-3);
    let splines = ModelSplines::fit(&model, tolerance).unwrap();
    let count = splines.control_count();
    assert!(splines.deviation() <= tolerance, "{}", splines.deviation());
    assert!(count < 80, "{count}");
    crate::write_file(&path, |out| splines.write_dxf(out)).unwrap();
    // Of every spline its layer, kind and many of its points.
    let script = "import sys, ezdxf\n\
        doc = ezdxf.readfile(sys.argv[1])\n\
        audit = doc.audit()\n\
        print(doc.dxfversion, doc.header['$INSUNITS'], len(audit.errors), len(audit.fixes), len(doc.modelspace()))\n\
        for e in audit.errors + audit.fixes: print(e.message, file=sys.stderr)\n\
        for s in doc.modelspace():\n\
        \x20   for p in s.construction_tool().approximate(200): print(s.dxf.layer, int(s.closed), *p)\n";
    let run = std::process::Command::new(&python).args(["-c", script]).arg(&path).output().unwrap();
    let output = String::from_utf8(run.stdout).unwrap();
    let mut lines = output.lines();
    let errors = String::from_utf8_lossy(&run.stderr);
    assert_eq!(lines.next(), Some("AC1015 4 0 0 3"), "{errors}");
    let mut points = 0;
    for line in lines {
        let fields: Vec<&str> = line.split(' ').collect();
        let index = if fields[0] == "PLANE_0012" { 12 } else { -3 };
        assert_eq!(fields[1] == "1", index == 12, "{line}");
        let p: Vec<f64> = fields[2..].iter().map(|f| f.parse().unwrap()).collect();
        let p = transect_geometry::Point3::new(p[0], p[1], p[2]);
        let frame = model.planes().frame(PlaneIndex(index));
        assert!(frame.height(&p).abs() < 1e-8);
        let curve = model.section(PlaneIndex(index)).unwrap().curves().next().unwrap();
        let off = curve.foot(&frame.plane_from_world(&p)).distance;
        assert!(off < tolerance + 1e-8, "{off}");
        points += 1;
    }
    assert!(points > 500, "{points}");
}
