//! Which pose belongs to which image.
//!
//! Images without a pose are left out and counted by reason. It is an error if none is left.

use super::layouts::{DepthImage, Layout, pose_file};
use crate::trajectory::{self, NoPose, Ordered, Timed, Trajectory};
use crate::{OpenOptions, Place, ReadError, row_major};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use transect_device::Note;

/// Largest difference in seconds between the time of an image and of the nearest pose. Source: the
/// default of TUM's own association. Doubled, gaps of 0.08 s in a trajectory are bridged.
const MOST_DIFFERENCE: f64 = 0.02;

/// The poses of images.
#[derive(Debug, Default)]
pub(super) struct Association {
    /// The images with a pose, by their place in the layout, and the row-major pose.
    pub(super) poses: Vec<(usize, [f64; 16])>,
    /// The images without a pose.
    losses: Vec<Losses>,
    /// The lines of the trajectory that hold no pose, in words.
    refused: Option<String>,
    pub(super) notes: Vec<Note>,
    /// The files that were read.
    pub(super) files: Vec<PathBuf>,
}

/// Images without a pose for one reason.
#[derive(Debug)]
struct Losses {
    reason: String,
    count: usize,
    /// The first image, and what its pose's file holds.
    first: String,
}

/// Why an image has no pose: the reason, and what its pose's file holds.
struct Loss(String, String);

/// Finds the poses of a layout's images.
pub(super) fn associate(layout: &Layout, options: &OpenOptions) -> Result<Association, ReadError> {
    let mut found = Association::default();
    if let Some(most) = options.max_time_difference.filter(|s| !(s.is_finite() && *s >= 0.0)) {
        let problem =
            format!("the setting `max_time_difference` is {most}; expected seconds, 0 or more");
        return Err(ReadError::unsupported(&layout.poses, Place::Whole, problem));
    }
    if layout.poses.is_dir() {
        for (index, image) in layout.images.iter().enumerate() {
            let file = pose_file(&layout.poses, &image.file);
            let read = |file: &Path| trajectory::read_one(file).map_err(unusable);
            let pose = file.as_deref().map_or_else(|| Err(no_file(&layout.poses)), read);
            found.files.extend(file);
            found.add(index, image, pose);
        }
    } else {
        found.files.push(layout.poses.clone());
        match Trajectory::read(&layout.poses)? {
            Trajectory::Ordered(poses) => found.in_order(layout, &poses)?,
            Trajectory::Timed(timed) => {
                found.in_time(layout, &timed, options.max_time_difference);
                return found.not_empty(layout);
            }
        }
    }
    if options.max_time_difference.is_some() {
        let problem = "the poses have no times, so the setting `max_time_difference` has no \
                       meaning; leave it out";
        return Err(ReadError::damaged(&layout.poses, Place::Whole, problem));
    }
    found.not_empty(layout)
}

fn no_file(folder: &Path) -> Loss {
    Loss(format!("without a pose file in {}", folder.display()), String::new())
}

fn unusable(error: ReadError) -> Loss {
    Loss("without a usable pose".to_owned(), format!(", {error}"))
}

/// Which image a pose of a trajectory without times belongs to.
enum Rule {
    /// Pose k belongs to image k. The heads of the poses may have other numbers.
    Order { ignores_heads: bool },
    /// Pose k belongs to the image whose name ends with the number k.
    Number,
    /// A pose belongs to the image whose name ends with the number in the head of the pose. Holds
    /// the places of the poses by these numbers.
    Head(BTreeMap<usize, usize>),
}

impl Rule {
    /// The heads count if the names of all images have numbers. Else pose k belongs to image k, if
    /// there are as many poses as images.
    fn of(layout: &Layout, poses: &Ordered) -> Result<Self, ReadError> {
        let images = &layout.images;
        let is_numbered = images.iter().all(|image| image.number.is_some());
        match poses.places_by_head() {
            Some(places) if is_numbered => Ok(Self::Head(places)),
            heads if poses.len() == images.len() => {
                Ok(Self::Order { ignores_heads: heads.is_some() })
            }
            _ if is_numbered => Ok(Self::Number),
            _ => {
                let problem = format!(
                    "{} poses, but {} images whose names have no numbers; expected one pose per \
                     image",
                    poses.len(),
                    images.len()
                );
                Err(ReadError::damaged(&layout.poses, Place::Whole, problem))
            }
        }
    }

    /// States the rule. `None` if images and poses have the same order.
    fn note(&self, layout: &Layout, poses: &Ordered) -> Option<String> {
        let (count, images) = (poses.len(), &layout.images);
        let rule = match self {
            Self::Order { ignores_heads: false } => return None,
            Self::Order { ignores_heads: true } => {
                "the numbers in the heads of the poses are not used, because not all images have \
                 numbers in their names: pose k belongs to image k"
                    .to_owned()
            }
            Self::Number => {
                "pose k (from 0) belongs to the image whose name ends with the number k".to_owned()
            }
            Self::Head(places) => {
                let numbers = images.iter().filter_map(|image| image.number);
                let known: BTreeSet<_> = numbers.filter(|n| places.contains_key(n)).collect();
                let (first, last) = (places.keys().next()?, places.keys().next_back()?);
                format!(
                    "their heads have numbers from {first} to {last}; a pose belongs to the image \
                     whose name ends with the number in the head; {} poses have no image",
                    count - known.len()
                )
            }
        };
        Some(format!("{count} poses for {} images; {rule}", images.len()))
    }

    /// The reason of an image without a pose.
    fn loss(&self) -> &'static str {
        match self {
            Self::Head(_) => "with numbers that no pose has in its head",
            _ => "with numbers beyond the last pose",
        }
    }
}

impl Association {
    fn add(&mut self, index: usize, image: &DepthImage, pose: Result<[f64; 16], Loss>) {
        let Loss(reason, detail) = match pose {
            Ok(pose) => return self.poses.push((index, pose)),
            Err(loss) => loss,
        };
        match self.losses.iter_mut().find(|known| known.reason == reason) {
            Some(known) => known.count += 1,
            None => {
                let first = format!("{}{detail}", image.file);
                self.losses.push(Losses { reason, count: 1, first });
            }
        }
    }

    /// The poses of a trajectory without times.
    fn in_order(&mut self, layout: &Layout, poses: &Ordered) -> Result<(), ReadError> {
        let rule = Rule::of(layout, poses)?;
        let text = rule.note(layout, poses);
        self.notes.extend(text.map(|text| Note::about(layout.poses.display(), text)));
        for (index, image) in layout.images.iter().enumerate() {
            let place = match &rule {
                Rule::Order { .. } => Some(index),
                Rule::Number => image.number,
                Rule::Head(places) => image.number.and_then(|n| places.get(&n).copied()),
            };
            let pose = match place.and_then(|place| poses.get(place)) {
                Some(pose) => pose.map_err(unusable),
                None => Err(Loss(rule.loss().to_owned(), String::new())),
            };
            self.add(index, image, pose);
        }
        Ok(())
    }

    /// The pose at the time of each image, interpolated between its neighbours in time.
    fn in_time(&mut self, layout: &Layout, timed: &Timed, most_difference: Option<f64>) {
        let most = most_difference.unwrap_or(MOST_DIFFERENCE);
        let path = layout.poses.display();
        let text = format!(
            "poses are interpolated at the times of the images; the nearest one is within {most} s \
             (the setting `max_time_difference`)"
        );
        self.notes.push(Note::about(&path, text));
        if let Some((count, first)) = &timed.refused {
            self.refused = Some(format!("lines without a pose: {count}; the first: {first}"));
        }
        if let Some((count, first)) = timed.contradicting() {
            let text = format!(
                "times with two poses that differ: {count}, and the first pose in the file counts; \
                 the first: {first}"
            );
            self.notes.push(Note::about(&path, text));
        }
        let span = timed.span().map_or_else(
            || "has no pose".to_owned(),
            |(first, last)| format!("has poses from {first} to {last}"),
        );
        for (index, image) in layout.images.iter().enumerate() {
            let at = image.time.map(|time| (time, timed.at(time, most)));
            let pose = match at {
                None => Err(Loss("without a time".to_owned(), String::new())),
                Some((_, Ok(pose))) => Ok(row_major(&pose)),
                Some((time, Err(NoPose::Outside))) => {
                    let detail = format!(" at {time}; {path} {span}");
                    Err(Loss("before the first pose or after the last".to_owned(), detail))
                }
                Some((time, Err(NoPose::TooFar))) => {
                    let detail =
                        format!(" at {time}; pass the setting `max_time_difference` to allow more");
                    Err(Loss(format!("without a pose within {most} s"), detail))
                }
            };
            self.add(index, image, pose);
        }
    }

    /// Turns the refused lines and the losses into notes, or into an error if no image has a pose.
    fn not_empty(mut self, layout: &Layout) -> Result<Self, ReadError> {
        let images = layout.images.len();
        let told = self.losses.iter().map(|Losses { reason, count, first }| {
            format!("{count} of {images} images are left out, {reason}; the first: {first}")
        });
        let told: Vec<String> = self.refused.iter().cloned().chain(told).collect();
        if self.poses.is_empty() {
            let problem = format!("no image has a pose: {}", told.join("; "));
            return Err(ReadError::damaged(&layout.poses, Place::Whole, problem));
        }
        let path = layout.poses.display();
        self.notes.extend(told.into_iter().map(|text| Note::about(&path, text)));
        Ok(self)
    }
}
