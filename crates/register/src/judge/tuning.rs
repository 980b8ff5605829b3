//! The numbers of judging.

/// Patches of a view that are compared with every other view. No unit. Chosen by hand: shares are
/// then known to 3 %. Doubled, judging takes twice the time.
pub const COMPARED_PATCHES: usize = 240;

/// Distance within which two patches are compared, over their radius. No unit. Chosen by hand: the
/// next parallel surface is usually farther away. Doubled, a shelf is compared with the floor.
pub const REACH: f64 = 1.0;

/// Quantile of the pairs of a view that is usual for it. No unit. Theory: of two equal groups of
/// two views or more, at least this share of pairs is within a group. Doubled, the worst pairs are
/// usual.
pub const USUAL_PAIR: f64 = 0.4;

/// Distance at which two patches contradict, over their noise. No unit. Theory: four standard
/// deviations are exceeded once in 16 000 patches. Doubled, small turns of noisy views pass.
pub const NOISE_FACTOR: f64 = 4.0;

/// Distance at which two patches contradict, over the distance by which views usually differ. No
/// unit. Measured on scans whose poses all err by chance: a view with twice the usual error passes.
/// Doubled, a view must be twice as far off to be named.
pub const CONTRADICTION: f64 = 6.0;

/// Distance that never contradicts, over the radius of a patch. No unit. Chosen by hand: about a
/// twentieth of the distance between pixels. Doubled, errors of a tenth of it pass.
pub const HARMLESS: f64 = 0.02;

/// Largest distance by which views usually differ, over the radius of a patch. No unit. Chosen by
/// hand: distances between unrelated surfaces within [`REACH`] have half of it as their median, and
/// real depth cameras reach 0.3. Doubled, it never holds.
pub const LARGEST_USUAL: f64 = 0.35;

/// Share of contradicting patches of right views. No unit. Measured on the bundled scenes: at most
/// 1 %. Doubled, a turn about the normal of most surfaces passes.
pub const BAD_IF_RIGHT: f64 = 0.02;

/// Share of contradicting patches of the median view from which the poses of all are wrong. No
/// unit. Measured: 1.1 % at most in 36 scans, also where all poses err; at one pose, 18 % of a room
/// whose floor and ceiling still agree, and 28 to 97 % of other scenes. Chosen between both.
/// Doubled, the room passes.
pub const BAD_IF_WRONG: f64 = 0.1;

/// Share of contradictions of right views that is usual, at least. No unit. Measured on simulated
/// rooms and kitchens: right views have up to 0.6 %, and views 0.2 m off more than 1 %. With two
/// fifths of it as many come back. Doubled, by reasoning, more come back beside the right place.
pub const LEAST_USUAL: f64 = 0.005;

/// Share of contradictions from which a view stands out: this much, and this multiple of the
/// largest share among the others. No unit. Measured on 50 frames of a depth camera: 6 % in most
/// views, 13 % in one sound view. Doubled, a turn about the vertical passes among level floors.
pub const STANDS_OUT: [f64; 2] = [0.05, 3.0];

/// Patches of a pair that count fully. No unit. Chosen by hand: half of the largest number of them.
/// Doubled, pairs of large overlap outvote the others.
pub const EVIDENCE_OF_A_PAIR: f64 = 240.0;

/// Logarithm of the odds that a view is right before anything is compared. No unit. Chosen by hand:
/// three contradictions without any agreement outweigh it. Doubled, five are needed.
pub const BLAME_COST: f64 = 8.0;

/// Rounds of the estimate of a motion. No unit. Measured on turns of 3 degrees: five suffice.
pub const MOTION_ROUNDS: usize = 8;

/// Distance of compared patches while a motion is looked for, over their radius. No unit. Chosen by
/// hand: turns of 3 degrees move surfaces by so much. Doubled, other surfaces mislead the motion.
pub const MOTION_REACH: f64 = 4.0;

/// Share of the contradictions that a motion or a scale must remove to be stated. No unit. Chosen
/// by hand. Doubled, none is ever stated.
pub const MENDED: f64 = 0.6;

/// Least distance by which a region is in front of free space, over the usual distance with noise
/// and over the radius of a patch. No unit. Chosen by hand: far from any error of a pose. Doubled,
/// flat objects pass.
pub const REGION_FRONT: [f64; 2] = [10.0, 1.0];

/// Fewest patches of a first look by which one view shows a region in another. No unit. Chosen by
/// hand: 2 of 240 are a region of [`REGION_CELLS`]. Doubled, a standing person at 5 m passes.
pub const REGION_HINTS: usize = 2;

/// Most views that are asked about a region, those with the most hints. No unit. Chosen by hand:
/// two suffice, and some see only a part. Doubled, looking for regions takes twice the time.
pub const REGION_WITNESSES: usize = 4;

/// Fewest cells of a region. No unit. Measured on 50 frames of a depth camera: false edges have up
/// to 40, and one object has 104 whose place is 35 mm off. Doubled, a standing person at 5 m
/// passes.
pub const REGION_CELLS: usize = 60;

/// Largest share of a view's cells in its regions. No unit. Chosen by hand: a view that contradicts
/// the others in more of it is wrong as a whole. Doubled, turned views pass for moving objects.
pub const REGION_SHARE: f64 = 0.4;
