//! The notes and warnings of a pose report, in words.

use super::{PoseReport, regions};
use crate::evaluate::digits;
use transect_device::{DepthOffsets, ImageOrder, Note};
use transect_geometry::LengthUnit;
use transect_register::{
    Finding, FoundReading, Motion, PoseOutcome, PoseReading, PoseRefinement, Reading, RefinedPose,
};

/// Most names of views that a warning lists of each group. Chosen by hand; doubled, the warning of
/// a scan of hundreds of views fills a screen.
const NAMES: usize = 8;

/// Largest standard deviation of a camera's error over its image, as a share of the error, that
/// sensors at a wrong place along their rays explain. No unit. Measured: a turntable whose axis is
/// 0.3 mm off has 0.01, and 40 simulated cameras with distortion have 0.85 and more. Chosen between
/// both; doubled or halved, none of these changes.
const EVEN: f64 = 0.2;

/// Standard deviation of a camera's error over its image, over the distance, from which the meaning
/// of its pixels is in question. No unit. Theory: lengths of rays that are read as depths are too
/// large by 6 % (standard deviation) in images 60° wide. Measured with `register`: 6 to 7 % in such
/// images of a kitchen, up to 1.3 % in sound images, simulated and real. Doubled, the former pass.
const MISREAD: f64 = 0.03;

impl PoseReport {
    /// Notes: how many views moved, and views whose pose nothing tells.
    pub fn notes(&self) -> Vec<Note> {
        let Some(refinement) = &self.refinement else {
            return self.alone().into_iter().map(Note::new).collect();
        };
        let poses = &refinement.poses;
        let moved = poses.iter().filter(|pose| pose.has_moved());
        let (count, all) = (moved.clone().count(), poses.len());
        let most = |of: fn(&RefinedPose) -> f64| moved.clone().map(of).fold(0.0, f64::max);
        let by = self.motion(most(|p| p.rotation), most(|p| p.translation));
        let mut notes = vec![match count {
            0 => format!("the poses of all {all} views stay as given{}", self.reason(refinement)),
            _ => format!("the poses of {count} of {all} views were refined, by up to {by}"),
        }];
        notes.extend(self.camera_error(refinement));
        let alone = poses.iter().filter(|pose| pose.outcome == PoseOutcome::Alone);
        let alone = alone.filter(|pose| !self.is_named(&pose.view));
        let alone: Vec<String> = alone.map(|pose| pose.view.clone()).collect();
        notes.extend(match alone.as_slice() {
            [] => None,
            [name] => Some(format!(
                "view {name} keeps its pose: no other view sees enough of the same surfaces"
            )),
            _ => Some(format!(
                "{} views keep their poses, since no other view sees enough of the same surfaces: \
                 {}",
                alone.len(),
                names(&alone)
            )),
        });
        notes.into_iter().map(Note::new).collect()
    }

    /// Whether a warning names a view.
    fn is_named(&self, name: &str) -> bool {
        self.judgement.findings.iter().any(|finding| match finding {
            Finding::Misplaced(found) => found.view == name,
            Finding::Scaled(found) => found.view == name,
            Finding::Apart { view } => view == name,
            Finding::Groups { .. } | Finding::Region(_) | Finding::All { .. } => false,
        })
    }

    /// Views whose surfaces no other view meets, and of which no warning tells.
    fn alone(&self) -> Option<String> {
        let told = self.is_doubtful();
        let alone = self.judgement.views.iter().filter(|v| v.compared == 0 && !told);
        let alone: Vec<String> = alone.map(|v| v.view.clone()).collect();
        match alone.as_slice() {
            [] => None,
            [name] => Some(format!(
                "view {name} overlaps no other view: nothing tells whether its pose is right"
            )),
            _ => Some(format!(
                "{} views overlap no other view, so nothing tells whether their poses are right: {}",
                alone.len(),
                names(&alone)
            )),
        }
    }

    /// The errors of the depth cameras; `None` of sound ones.
    fn camera_error(&self, refinement: &PoseRefinement) -> Option<String> {
        let (distance, unit) = (refinement.distance, self.unit);
        let error_at = |offsets: &&DepthOffsets| offsets.error_at(distance);
        let errors = || refinement.poses.iter().filter_map(|pose| pose.depth_offsets.as_ref());
        let largest = errors().max_by(|a, b| error_at(a).total_cmp(&error_at(b)))?;
        let (error, views) = (digits(error_at(&largest)), errors().count());
        let scale = match largest.scale() {
            1.0 => String::new(),
            scale => format!(
                ", and its depths are {:.4} times what the poses ask for (check a known length)",
                scale.recip()
            ),
        };
        let what = match self.in_store {
            true => {
                "a store keeps its images as they are; to correct them, register the scan and \
                 build the store from the scan that it writes"
            }
            false => "its images are corrected",
        };
        Some(format!(
            "the depth camera errs alike in its {views} images, by {error} {unit} (root mean \
             square) at the median distance of {} {unit}{scale}; {what}{}{}",
            digits(distance),
            hint_of_even_error(largest, distance),
            hint_of_misread_pixels(largest, distance)
        ))
    }

    /// The warning that another convention explains the contradictions.
    pub fn misread(&self) -> Option<String> {
        self.found_reading.as_ref().map(|found| self.convention(found))
    }

    /// Why the given poses are no beginning for a refinement: another convention explains the
    /// contradictions, or most views contradict each other.
    pub fn unfit(&self) -> Option<String> {
        let all = self.judgement.findings.iter().find(|f| matches!(f, Finding::All { .. }));
        self.misread().or_else(|| all.map(|finding| self.finding(finding)))
    }

    fn convention(&self, found: &FoundReading) -> String {
        let FoundReading { reading, given, read } = found;
        let shares = [given.agreeing, given.contradicting, read.agreeing, read.contradicting];
        let [agree, contradict, agree_read, contradict_read] = shares.map(percent);
        let advice = match (self.in_store, reading) {
            (true, Reading::Pose(_) | Reading::Image(_)) => format!(
                "A store reads its scans as they are: write each scan anew, registered with \
                 {reading}, and make the store of those"
            ),
            (true, Reading::PixelsHold(scale)) => format!(
                "A store reads its scans as they are: write folders of depth images anew, \
                 registered with {reading}. In a scan.json, state \"holds\": \"{scale}\" for each \
                 depth camera. Make the store of those"
            ),
            _ => advice(*reading, self.unit),
        };
        format!(
            "the poses contradict each other, and agree if they are read another way: {}. As given, \
             {agree} of the surface lies on that of other views, and {contradict} of the comparisons \
             contradict; read that way, {agree_read} and {contradict_read}. {advice}",
            reading.meaning()
        )
    }

    /// Warnings: what contradicts, and views that were far off before they were refined.
    ///
    /// Where another convention explains the contradictions, they are not listed.
    pub fn warnings(&self) -> Vec<String> {
        if let Some(misread) = self.misread() {
            return vec![misread];
        }
        let refined = self.refinement.iter().flat_map(|refinement| &refinement.poses);
        let all = self.judgement.findings.iter();
        let findings = all.filter(|f| !matches!(f, Finding::Region(_))).map(|f| self.finding(f));
        let lens = self.refinement.iter().filter_map(|refinement| refinement.focal_over_true);
        let lens = lens.map(|[fx, fy]| {
            format!(
                "the focal lengths of the depth camera are wrong: fx is {fx:.4} and fy {fy:.4} times \
                 what the images ask for. The given poses stay, since they would bend to that. \
                 Divide fx and fy by these numbers, or calibrate the camera, and refine again"
            )
        });
        lens.chain(refined.filter_map(|pose| self.outcome(pose)))
            .chain(findings)
            .chain(self.regions())
            .collect()
    }

    fn regions(&self) -> Vec<String> {
        let regions = self.judgement.findings.iter().filter_map(|finding| match finding {
            Finding::Region(region) => Some(region),
            _ => None,
        });
        regions::texts(&regions.collect::<Vec<_>>(), self.judgement.views.len(), self.unit)
    }

    fn outcome(&self, pose: &RefinedPose) -> Option<String> {
        let RefinedPose { view, rotation, translation, .. } = pose;
        match pose.outcome {
            PoseOutcome::BroughtBack => Some(format!(
                "view {view} was {} off, farther than the other views, and was brought back. Check \
                 where its pose comes from",
                self.motion(*rotation, *translation)
            )),
            // What is wrong with its lengths is a finding.
            PoseOutcome::Misplaced if self.is_scaled(view) => None,
            PoseOutcome::Misplaced => Some(format!(
                "view {view} contradicts the others, and no nearby pose agrees with them; it keeps \
                 its pose. Correct the pose, or {}",
                self.leave_it_out()
            )),
            PoseOutcome::Refined | PoseOutcome::Kept | PoseOutcome::Alone => None,
        }
    }

    fn is_scaled(&self, view: &str) -> bool {
        let found = &self.judgement.findings;
        found.iter().any(|f| matches!(f, Finding::Scaled(scaled) if scaled.view == view))
    }

    fn finding(&self, finding: &Finding) -> String {
        match finding {
            Finding::Misplaced(found) => {
                let (view, against) = (&found.view, found.against);
                let [share, usual] = [found.contradicting, found.usual].map(percent);
                format!(
                    "view {view} contradicts the others: {share} of the surface that it shares \
                     with {against} views lies apart from theirs or where they saw free space; \
                     for other views it is at most {usual}. {}",
                    self.remedy(found.motion)
                )
            }
            Finding::Scaled(found) => {
                let (view, factor) = (&found.view, found.factor);
                let [given, corrected] = [found.contradicting, found.corrected].map(percent);
                format!(
                    "view {view} has lengths that are {factor:.4} times those of the other views: \
                     {given} of the surface that it shares with them contradicts, and {corrected} \
                     with its lengths divided by that. Check the unit of its file (\"scale\" in \
                     scan.json) and its calibration"
                )
            }
            Finding::Apart { view } => format!(
                "view {view} meets no surface of another view, although the others overlap. If it \
                 should, check its pose, or {}",
                self.leave_it_out()
            ),
            Finding::Groups { groups, contradicting } => {
                of_groups(groups, &percent(*contradicting))
            }
            Finding::Region(region) => regions::text(region, self.unit),
            Finding::All { contradicting, one_pose } => {
                self.all_contradict(*contradicting, *one_pose)
            }
        }
    }

    /// Why no view moved.
    fn reason(&self, refinement: &PoseRefinement) -> String {
        if let Some(held) = self.held_by_prior() {
            return format!(": {held}");
        }
        let kept = refinement.poses.iter().any(|pose| pose.outcome == PoseOutcome::Kept);
        let reason = match refinement.left_out_pairs {
            Some(change) if change < 0.0 && kept => {
                ": no view would move by clearly more than the images leave uncertain"
            }
            Some(_) if kept => {
                ": observations that were left out of the estimate do not agree better with other \
                 poses"
            }
            _ => "",
        };
        reason.to_owned()
    }

    /// What is stated of the poses, if it holds them where the images contradict them.
    fn held_by_prior(&self) -> Option<String> {
        let by_images = self.prior_by_images?;
        Some(format!(
            "what is stated of their errors holds them, but by the images they are wrong by {} at \
             least (root mean square). State more than that (the setting `prior`, \
             \"pose_sigma\" in scan.json), or state nothing. No standard deviations are written",
            self.motion(by_images.rotation, by_images.translation)
        ))
    }

    fn all_contradict(&self, contradicting: f64, one_pose: bool) -> String {
        let (count, share) = (self.judgement.views.len(), percent(contradicting));
        let cause = if let Some(held) = self.held_by_prior() {
            format!("The poses stay: {held}")
        } else if one_pose {
            "All have the same pose, as if they had never been registered. Register them with the \
             scanner's program, and export the poses too"
                .to_owned()
        } else {
            format!(
                "No view stands out. Check that the poses belong to this scan, and their \
                 convention ({})",
                self.other_convention()
            )
        };
        format!(
            "the {count} views contradict each other: {share} of the surface that the median view \
             shares with others lies apart from theirs or where they saw free space. {cause}"
        )
    }

    fn remedy(&self, motion: Option<Motion>) -> String {
        match motion {
            Some(motion) if self.refinement.is_some() => format!(
                "It would agree ({} left) if it moved by {}, which refinement did not find: check \
                 its pose, or {}",
                percent(motion.contradicting),
                self.motion(motion.rotation, motion.translation),
                self.leave_it_out()
            ),
            Some(motion) => format!(
                "It agrees ({} left) if it moves by {}; {}",
                percent(motion.contradicting),
                self.motion(motion.rotation, motion.translation),
                if self.in_store {
                    "transect register does that"
                } else {
                    "the setting `refine_poses` and transect register do that"
                }
            ),
            None => format!(
                "No nearby pose agrees: check its pose and its convention ({}), or {}",
                self.other_convention(),
                self.leave_it_out()
            ),
        }
    }

    /// How poses are read by another convention. A store's commands read its scans as they are.
    fn other_convention(&self) -> &'static str {
        match self.in_store {
            true => {
                "for another one, write the scan anew with transect register SCAN \
                 --pose-convention NAME --out DIR, and then run transect replace-view"
            }
            false => "the setting `pose_convention`",
        }
    }

    fn leave_it_out(&self) -> &'static str {
        match self.in_store {
            true => "take it out with transect remove-view",
            false => "leave it out with the setting `views`",
        }
    }

    /// An angle in radians and a length, in words.
    fn motion(&self, rotation: f64, translation: f64) -> String {
        format!("{}° and {} {}", digits(rotation.to_degrees()), digits(translation), self.unit)
    }
}

/// The advice for files without a scale; a factor follows.
const POINT_FILES: &str = "E57, PTX, PCD and PLY files have no scale: export them with coordinates \
                           that are multiplied by";

/// The advice for a reading. Where the poses are in the scan's unit, the images are wrong.
fn advice(reading: Reading, unit: LengthUnit) -> String {
    let (factor, images) = match (reading, unit) {
        (Reading::Pose(PoseReading::Metres), LengthUnit::Metre) => (0.001, LengthUnit::Millimetre),
        (Reading::Pose(PoseReading::Millimetres), LengthUnit::Millimetre) => {
            (1000.0, LengthUnit::Metre)
        }
        (Reading::Distances(factor), _) => {
            return format!(
                "Multiply their \"scale\" in scan.json, or the setting `depth_scale` of a folder \
                 of depth images, by {factor}; without a scale, state {factor}. {POINT_FILES} \
                 {factor}"
            );
        }
        (Reading::Image(ImageOrder::UpsideDown), _) => {
            return format!(
                "Pass {reading} if a viewer shows the images on their heads. If it shows them \
                 upright, y points up in the camera and in the poses (as in ICL-NUIM), and that \
                 setting would mirror the model: for a folder of depth images, state fy as a \
                 negative number (the setting `camera` FX,-FY,CX,CY)"
            );
        }
        (Reading::PixelsHold(scale), _) => {
            return format!(
                "Pass {reading} for a folder of depth images. In scan.json, state \"holds\": \
                 \"{scale}\" for each of its depth cameras"
            );
        }
        (Reading::AsStated, _) => return "Leave out the setting `pose_convention`".to_owned(),
        _ => return format!("Pass {reading}"),
    };
    format!(
        "The unit {unit} is that of the poses, so correct the images: multiply their \"scale\" in \
         scan.json, or the setting `depth_scale` of a folder of depth images, by {factor}; without \
         a scale, state {factor}. {POINT_FILES} {factor}. Or state \"unit\": \"{images}\" in \
         scan.json, or the setting `unit` {images} for another format, and pass {reading}"
    )
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// Groups of views that contradict each other in a share of what they see in common.
fn of_groups(groups: &[Vec<String>], share: &str) -> String {
    let texts: Vec<String> = groups.iter().map(|group| names(group)).collect();
    match (&texts[..], groups.iter().all(|group| group.len() == 1)) {
        ([one, other], true) => format!(
            "views {one} and {other} contradict each other: {share} of the surface that they share \
             lies apart or where one of them saw free space. No other view tells which is wrong: \
             check both poses"
        ),
        _ => format!(
            "the views agree within {} groups that contradict each other: {}; {share} of the \
             surface that they share contradicts. Check that all poses are in one world",
            groups.len(),
            texts.join(" | ")
        ),
    }
}

/// The first names of a group, and the number of the others.
fn names(group: &[String]) -> String {
    let first = group.iter().take(NAMES).map(String::as_str).collect::<Vec<_>>().join(", ");
    match group.len().saturating_sub(NAMES) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

/// What to check where the error of a camera is the same all over the image.
///
/// Refinement takes poses to err one by one. An error that all of them have in the sensor's frame
/// is explained by fewer numbers as one of the camera.
fn hint_of_even_error(offsets: &DepthOffsets, distance: f64) -> &'static str {
    if offsets.spread_at(distance) < EVEN * offsets.error_at(distance) {
        ". The error is the same all over the image, as if all sensors stood that far off along \
         their rays: check the axis of a turntable, or the sensor's place on its mount"
    } else {
        ""
    }
}

/// What to check where the error of a camera differs over the image by more than cameras err.
///
/// Images that hold lengths of rays seem to have such an error. Where the poses err too, the views
/// may agree too little under the right reading for it to be named.
fn hint_of_misread_pixels(offsets: &DepthOffsets, distance: f64) -> &'static str {
    if offsets.spread_at(distance) > MISREAD * distance {
        ". Cameras err less: check whether the images hold depths or lengths of rays (\"holds\" in \
         scan.json, transect register FOLDER --pixels-hold NAME), and check the focal lengths"
    } else {
        ""
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_device::PinholeScale;
    use transect_register::{Accord, Judgement, Misplaced};

    /// A store's commands refuse the option that reads poses by another convention.
    #[test]
    fn a_store_reads_poses_anew_from_a_scan_that_is_written_anew() {
        let (view, motion) = ("a".to_owned(), None);
        let found = Misplaced { view, contradicting: 0.5, usual: 0.1, against: 3, motion };
        let all = Finding::All { contradicting: 0.5, one_pose: false };
        for finding in [Finding::Misplaced(found), all] {
            let told = |in_store| {
                let judgement = Judgement {
                    findings: vec![finding.clone()],
                    views: Vec::new(),
                    usual_distance: 0.01,
                };
                let unit = LengthUnit::Metre;
                PoseReport {
                    unit,
                    found_reading: None,
                    judgement,
                    refinement: None,
                    prior_by_images: None,
                    in_store,
                    along_faces: Default::default(),
                }
                .warnings()
                .concat()
            };
            assert!(told(false).contains("(the setting `pose_convention`)"), "{}", told(false));
            let anew = "transect register SCAN --pose-convention NAME --out DIR";
            let told = told(true);
            assert!(!told.contains("the setting") && told.contains(anew), "{told}");
            assert!(told.contains("transect replace-view"), "{told}");
        }
    }

    #[test]
    fn a_store_is_made_anew_of_scans_whose_pixels_hold_another_length() {
        let share = |agreeing, contradicting| Accord { agreeing, contradicting };
        let report = PoseReport {
            unit: LengthUnit::Metre,
            found_reading: Some(FoundReading {
                reading: Reading::PixelsHold(PinholeScale::RayLength),
                given: share(0.4, 0.3),
                read: share(0.8, 0.0),
            }),
            judgement: Judgement { findings: Vec::new(), views: Vec::new(), usual_distance: 0.01 },
            refinement: None,
            prior_by_images: None,
            in_store: true,
            along_faces: Default::default(),
        };
        let told = report.warnings().concat();
        for part in ["`pixels_hold` ray_length", "\"holds\": \"ray_length\"", "Make the store"] {
            assert!(told.contains(part), "{part}: {told}");
        }
    }

    #[test]
    fn a_camera_that_errs_by_more_than_cameras_points_to_the_meaning_of_its_pixels() {
        let hint = |share: f64| {
            // At a depth of 2, this share is the largest error. It grows outwards from the middle.
            let error = |k: usize| share * ((k % 9) as f64 - 4.0).powi(2) / 16.0 / 2.0;
            let offsets = DepthOffsets::new(7, 9, (0..63).map(error).collect()).unwrap();
            hint_of_misread_pixels(&offsets, 2.0)
        };
        assert!(hint(0.15).contains("lengths of rays"));
        assert_eq!(hint(0.02), "");
    }

    #[test]
    fn an_even_error_of_the_camera_points_to_the_place_of_the_sensor() {
        let hint = |of: fn(usize) -> f64| {
            let offsets = DepthOffsets::new(7, 9, (0..63).map(of).collect()).unwrap();
            hint_of_even_error(&offsets, 2.0)
        };
        assert!(hint(|k| 0.01 + 0.001 * (k % 2) as f64).contains("turntable"));
        assert_eq!(hint(|k| 0.01 - 0.02 * (k % 2) as f64), "");
        assert_eq!(hint(|k| 0.0003 * k as f64), "");
    }
}
