//! The numbers that this crate does not derive from the data.

/// Cells of a view, about. No unit. Chosen by hand: patches of a scan of half a million pixels then
/// have 8 by 8 pixels. Doubled, a coarse copy takes twice the memory, and curved surfaces are
/// followed more closely.
pub const CELLS: usize = 8192;

/// The same of a copy for judging alone. No unit. Measured on 12 scans of a room and on 40 frames
/// of a depth camera: judging takes 3 and 5 % of a run. Doubled, the copies take twice the time.
pub const QUICK_CELLS: usize = 2048;

/// Most blocks of pixels of the space that a view looked through. No unit. Chosen by hand: blocks
/// of an image of half a million pixels then have 4 by 4 of them. Doubled, the space of larger
/// images takes twice the memory.
pub const SPACE_BLOCKS: usize = 32768;

/// Fewest pixels along the side of a cell. No unit. Theory: a surface of second order has six
/// unknowns, and 4 by 4 pixels leave ten values to tell its noise. Doubled, images of few rows have
/// hardly any patches.
pub const LEAST_STEP: usize = 4;

/// Share of the pixels of a cell that a patch needs. No unit. Chosen by hand: an edge through the
/// middle of a cell leaves half of them. Doubled, no cell with a missing pixel has a patch.
pub const LEAST_FILLED: f64 = 0.5;

/// Share of the pixels of a cell with a sample, one more aside, from which it shows that nothing
/// else is there. No unit. Chosen by hand: scanners lose 1 or 2 % of their pixels at random. At 1,
/// such scanners have no free space; at half of it, thin objects hide in missing pixels.
pub const LEAST_WHOLE: f64 = 0.9;

/// Largest angle of incidence of a patch, in degrees. Chosen by hand: a little below the 78 degrees
/// of range jumps in `partial`. At 89 degrees, steps between two surfaces pass for patches.
pub const MAX_INCIDENCE_DEGREES: f64 = 75.0;

/// Departure of the samples of a patch from it, over their noise, from which it is no patch. No
/// unit. Theory: with ten samples to spare, noise exceeds it less than once in 10 000 patches.
/// Doubled, creases pass for patches.
pub const ROUGH: f64 = 2.0;

/// Standard deviations by which that departure exceeds the one of noise, from which it is an error
/// of the patch itself. Theory: noise alone exceeds it once in 10 000 patches. The 36 samples of a
/// patch show a fold or a rim that noise hides in each of them. Measured on three scans of folded
/// sheet metal at poses 0.4 mm off: refined poses err by 0.15 mm. Without the rule they err by 0.8
/// to 1.2 mm, with a false scale of the camera. If such patches are left out, views below a part
/// are displaced against those above it. On four drifts of a hand, medians of sections fall by 2
/// to 20 %. Doubled, most folds count as before.
pub const FOLDED: f64 = 3.72;

/// Departure that is allowed in images without noise, over the distance between samples. No unit.
/// Chosen by hand: far below what a crease leaves in a cell. Views that lie off each other by less
/// are not misplaced. Doubled, shallow creases pass.
pub const SAMPLING_ROUGH: f64 = 0.03;

/// Largest distance of the neighbours of a facet, over that between samples. No unit. Theory: a
/// neighbour along a diagonal is 1.41 of it away. Doubled, facets beside a jump reach across it.
pub const FACET_REACH: f64 = 1.5;

/// Largest noise of a facet's samples, over the distance between their rays. No unit. Theory: its
/// normal errs by 20 degrees then, and twice as much is [`ALIKE_DEGREES`]. Doubled, noise
/// passes for relief.
pub const FACET_NOISE: f64 = 0.89;

/// Fewest samples of a facet. No unit. Theory: two rows of three, as beside a jump. Doubled, there
/// is none.
pub const LEAST_IN_FACET: usize = 6;

/// Most facets of a view that are looked up in another one. No unit. Chosen by hand. Measured on
/// three scans of a wall with windows: with a quarter of them, poses err by up to twice as much.
/// Doubled, the rounds of few views take longer.
pub const FACETS: usize = 4096;

/// Patches that are looked up for each facet, where their number is limited. No unit. Chosen by
/// hand: facets count where patches tell nothing. At 1, the rounds of twelve views of parts take
/// half as long again, and poses err as much. Doubled, few facets are left between many views.
pub const FACETS_SHARE: usize = 4;

/// Largest angle between the normals of two patches of one surface, in degrees. Chosen by hand:
/// less than half a right angle keeps the sides of a corner apart, with room for a turned view.
/// Doubled, patches around a corner meet.
pub const ALIKE_DEGREES: f64 = 40.0;

/// Standard deviations that a patch may lie off another. No unit. Theory: all but one in 400.
/// Doubled, other surfaces behind the first ones count.
pub const GATE: f64 = 3.0;

/// Patches of a view that decide whether a pair of views overlaps. No unit. Chosen by hand: a
/// fiftieth of them must meet. Doubled, finding the pairs takes twice the time.
pub const OVERLAP_SAMPLES: usize = 256;

/// Observations of a pair that tell a median. No unit. Theory: its relative error is then 1.17 /
/// 16, or 7 %. Doubled, the spread of the pairs takes twice the time.
pub const QUANTILE_SAMPLES: usize = 256;

/// Patches of a view that show where the view moves. No unit. Chosen by hand: places that are
/// spread over the image; twelve would tell a rigid motion. Doubled, the common motion takes twice
/// the time.
pub const MOTION_POINTS: usize = 256;

/// Fewest patches by which two views meet. No unit. Theory: a rigid motion has six unknowns, and a
/// median of twelve is off by less than half. Doubled, small overlaps are lost, and views of a
/// chain have no pairs left.
pub const LEAST_MEETINGS: usize = 12;

/// Other views that a view is compared with at most, those with the largest overlap. No unit.
/// Chosen by hand: time and memory then grow with the number of views, not with its square.
/// Doubled, 200 views take up to twice the memory.
pub const PARTNERS: usize = 60;

/// Samples that are looked up for each pair at least, however many pairs there are. No unit. Chosen
/// by hand: a fifth of them are [`LEAST_MEETINGS`]. Doubled, 120 views that all overlap take twice
/// the memory.
pub const LEAST_LOOKED_UP: usize = 64;

/// Most observations of all pairs together in one round. No unit. Chosen by hand: a scan of
/// twelve views then uses all its patches. Doubled, a round takes twice the time.
pub const OBSERVATIONS: usize = 400_000;

/// Most samples that an observation represents when its weight is computed. No unit. Measured with
/// 120 simulated frames of a depth camera: the poses err by 8.5 mm at 2, by 8.7 mm at 3, by 9.4 mm
/// at 5, and by 13.8 mm without a limit, because the prior outweighs the observations. Between 2
/// and 5, errors of 40 frames change by up to 11 %.
pub const MOST_REPRESENTED: f64 = 3.0;

/// How far poses may be off at first: a rotation, in degrees. Chosen by hand: a third of the turn
/// that a view off by ten degrees needs. Doubled, patches of other surfaces meet.
pub const FIRST_ROTATION_DEGREES: f64 = 3.0;

/// The same for a translation, over the median distance of the patches from their sensors. Chosen
/// by hand: what that rotation moves. Doubled, patches of other surfaces meet.
pub const FIRST_TRANSLATION: f64 = 0.05;

/// Most rounds of finding meetings and solving, after the first ones. No unit. Measured: rooms
/// settle after two. The poses of 40 frames of a depth camera err by 4.8 mm after 16 rounds and
/// after 24. Doubled, depth cameras and round parts take nearly twice the time.
pub const ROUNDS: usize = 16;

/// Change of a motion, over its standard deviation, below which it has settled. No unit.
/// Chosen by hand: far below what the motion is uncertain by. Doubled, weakly determined motions
/// stop halfway.
pub const SETTLED: f64 = 0.05;

/// Share of the last change that each round goes on by. No unit. Theory: where rounds leave 95 % of
/// an error, this share shrinks it fastest (Polyak, 1964). Doubled, rounds run away.
pub const MOMENTUM: f64 = 0.6;

/// Rounds before that. No unit. Chosen by hand: the first one finds the errors of cameras and moves
/// all poses. Doubled, momentum has few rounds left.
pub const BEFORE_MOMENTUM: usize = 2;

/// Blocks along each side of an image within which errors may be shared. No unit. Chosen by hand:
/// errors of lenses vary over the whole image. Doubled, errors over a quarter of an image are taken
/// for independent.
pub const BLOCKS: usize = 4;

/// Fall of the sum of squares, over the variance of a sample, up to which a bent patch is taken for
/// a plane. No unit. Theory: two for each of the three numbers that a bend adds (Akaike, 1974).
/// Doubled, slight bends are taken for planes.
pub const FLAT: f64 = 6.0;

/// Updates of the prior in a round. No unit. Chosen by hand. Doubled, the prior settles in
/// fewer rounds that take longer.
pub const PRIOR_ROUNDS: usize = 3;

/// Share of a drift in the variance of the poses' errors, before anything is known of it. No unit.
/// Chosen by hand: half. Doubled, errors have no part of their own.
pub const FIRST_SHARE: f64 = 0.5;

/// Fewest views whose poses may drift. No unit. Measured where poses err one by one, and a drift is
/// looked for all the same: places of 16 frames err by 2 % more, and turns of 12 views around parts
/// by 0.027° in place of 0.017°. Those of 31 and 40 frames tell that there is none. Where poses do
/// drift, 40 views err by a quarter less. Doubled, the drift of 31 stays.
pub const LEAST_DRIFTING: usize = 20;

/// Variance of the motion that all views of a drift share, over that of the others. No unit.
/// Theory: it is free, since it is taken out in the end; a finite one keeps the system definite.
/// Doubled, nothing changes.
pub const SHARED: f64 = 100.0;

/// Least share of each of the two. No unit. Chosen by hand: a thousandth is far below what the
/// evidence tells. Doubled, nothing changes; at 0, a part could never grow again.
pub const LEAST_SHARE: f64 = 1e-3;

/// Updates of the share for errors as they are. No unit. Measured in a simulated kitchen of 31
/// frames whose poses err one by one: with one update, the share is 0.05 after all rounds, and the
/// odds of a wrong scale are 61. With ten and with forty it is [`LEAST_SHARE`], and they are 940
/// and 840. The scale is found then, and sections err by 2.8 mm in place of 9.0. Doubled, nothing
/// changes.
pub const SHARE_ROUNDS: usize = 50;

/// Standard deviations within which a neighbouring patch continues a patch. Theory: all but one in
/// 400. Doubled, normals are rounded across creases.
pub const SAME_SURFACE: f64 = 3.0;

/// Error of a camera, over the noise of a patch, below which its images stay as they are. No unit.
/// Chosen by hand: it adds half a per cent to that noise. Measured on 72 scans of sound cameras: 19
/// were told that they err, by up to 0.03 mm. Doubled, larger errors stay in the images.
pub const NEGLIGIBLE: f64 = 0.1;

/// Rounds before the size of the errors is estimated. No unit. Measured: poses 20 mm off are
/// within noise after two to four. Doubled, a refinement takes a third longer.
pub const SETTLING: usize = 8;

/// Rounds of a view that is brought back, before the others move with it. No unit. Theory: with
/// [`NARROWING`], the tolerance is then a fiftieth of what the first pose is off. Doubled, bringing
/// a view back takes longer.
pub const SETTLING_ALONE: usize = 12;

/// Factor on this tolerance from round to round. No unit. Chosen by hand: what is off shrinks at
/// least as fast. Doubled, the tolerance would grow.
pub const NARROWING: f64 = 0.7;

/// Share of what may be wrong at first, below which poses and cameras are taken for exact. No unit.
/// Chosen by hand: a thousandth of three degrees moves a point 5 m away by 0.3 mm. Doubled, smaller
/// errors stay.
pub const EXACT: f64 = 1e-3;

/// Most views that are left out as misplaced. No unit. Chosen by hand: each costs a refinement.
/// Doubled, scans with many wrong views take up to twice the time.
pub const MOST_MISPLACED: usize = 4;

/// Residual of a misplaced view over the median of all views. No unit. Chosen by hand: views of
/// other surfaces and distances differ by less. Doubled, views half a metre off pass.
pub const MISPLACED: f64 = 4.0;

/// Distance of a view from its given place over the median of all, beyond which it has less weight
/// in their common motion. No unit. Theory: of shifts that are normal and alike in three
/// directions, one in 10 000 is as large. Doubled, a wrong view draws the others farther.
pub const COMMON_CUT: f64 = 3.0;

/// Sum of the roots of the distances of all views, over that of the fit of all, below which the
/// motion of one view is the common one. No unit. Theory: one view off among exact ones leaves 0.71
/// of it with two views, 0.51 with three, and less with more. Measured on six simulated scans of 8
/// to 40 views that all err by chance: 0.94 to 1.06. Doubled, the common motion of few views is
/// that of one of them.
pub const CLEARLY_LESS: f64 = 0.65;

/// Most fits of the common motion. Theory: each takes a tenth of what a wrong view draws, or less.
/// Doubled, nothing changes.
pub const COMMON_ROUNDS: usize = 10;

/// Turn, or shift, of a view that was far off over the median of all views. No unit. Theory: those
/// that are all drawn from one normal distribution exceed it less than once in a million. Doubled,
/// it is not told.
pub const FAR_OFF: f64 = 5.0;

/// Most parts of the pairs that are left out in turn. No unit. Measured: with two, the pairs that
/// are left of four views do not determine them. Doubled, judging takes twice the time.
pub const PARTS: usize = 10;

/// Odds of the refined poses over the given ones, by pairs that are left out, above which views
/// move. No unit. Theory: strong evidence (Kass and Raftery, 1995). Measured on 14 simulated scans
/// with exact poses and noise: 5 at most, and on 24 with wrong poses e^140 at least. Doubled, the
/// limit grows by a fifth of a standard deviation.
pub const POSE_ODDS: f64 = 20.0;

/// Sums in which threads add up what all pairs say. No unit. Chosen by hand: results do not depend
/// on the number of threads, of which four have work. Doubled, each round adds up twice as many
/// matrices.
pub const SUMS: usize = 4;

/// Least share of a depth camera's rays along its axis: the cosine of half the field of view. No
/// unit. Chosen by hand: lenses see 120 degrees at most without large distortion. Doubled, only
/// the axis itself passes.
pub const LEAST_AHEAD: f64 = 0.5;

/// Rows and columns of the grid of a depth camera's error. No unit. Chosen by hand: errors of
/// lenses and patterns vary over a fifth of the image or more. Doubled, the cost of a round
/// doubles, and patches of noise pass for errors of the camera.
pub const CAMERA_GRID: (usize, usize) = (7, 9);

/// How far a depth camera may err at first, as a share of the median distance. No unit. Theory:
/// makers state 1 to 2 % for depth cameras. Doubled, or halved, the rounds that follow
/// estimate the same offsets. The odds of a wrong scale or focal length are halved, or doubled.
pub const FIRST_CAMERA_ERROR: f64 = 0.01;

/// Largest standard deviation of the level of a camera's offsets while views settle, over that of
/// the other offsets. No unit. Measured: a sound camera's level vanishes with the others. With 100,
/// six views around a part err by up to a tenth more. With 10, a kitchen whose walls lengthen
/// depths has a false focal length; with 20 to 50 it has none. Doubled, nothing changes in
/// kitchens.
pub const LEVEL_OVER_OTHERS: f64 = 30.0;

/// Standard deviation of a focal length or level that is to be told, over the stated one. No unit.
/// Measured: with noise that neighbouring pixels share, positions err by 1.3 to 1.6 times of what
/// is stated, and the offsets of a camera by 1.5 to 1.7 times. At 1, a half of the red kitchen and
/// a kitchen with four times the usual noise have false focal lengths, which stop their refinement.
/// Doubled, 1 % is not told in a kitchen.
pub const CAMERA_SIGMAS: f64 = 2.0;

/// Odds from which the focal length of a depth camera is taken for wrong, or its level for larger
/// than its other offsets. No unit. Theory: strong evidence (Kass and Raftery, 1995). In 19
/// simulated scans with right focal lengths, and in the red kitchen, the first odds are 0.8 at
/// most. Those of levels are 7 at most in ten frames of a kitchen, and 20 in 40 with one of 0.6 %.
/// Doubled, the limit grows by a fifth of a standard deviation.
pub const CAMERA_ODDS: f64 = 20.0;

/// Most rounds in which views settle anew after a level is held. No unit. Theory: distances are
/// linear in all unknowns close to the solution, so one would do but for what meets elsewhere.
/// Measured in a kitchen: the changes of the second and later ones are a quarter of their standard
/// deviation at most. Doubled, refining takes longer.
pub const LEVEL_ROUNDS: usize = 4;

/// Odds from which the scale of a depth camera is taken for wrong, and taken out of its images. No
/// unit. Theory: very strong evidence (Kass and Raftery, 1995), since a false scale displaces all
/// surfaces. Measured: a drifting camera with the right scale has odds of 20 to 38 for one that is
/// 0.8 % off, and its sections would err by 18 mm in place of 1.5. Of nine wrong scales of 2 to 16
/// per cent one is no longer found, of 2 % in a kitchen at wrong poses. Doubled, the limit grows by
/// a fifth of a standard deviation.
pub const SCALE_ODDS: f64 = 150.0;

/// Fewest views for which a wrong scale is looked for. No unit. Theory: of two cameras that face
/// each other, one that stands too far away looks like depths that are too small, and a third view
/// seldom contradicts. Measured in a room, one of three views 20 mm off: sections err by 18 mm with
/// a false scale, and by 0.5 mm at the given poses; of four views, the wrong one is brought back.
/// Doubled, four to seven views keep a wrong scale.
pub const LEAST_FOR_SCALE: usize = 4;

/// Most runs of [`ROUNDS`] with free scales, each from the given poses. No unit. Measured with
/// eleven views around a part, at their true poses, whose depths are 3.5 % too large: 2.1 % are
/// found after one run, 3.2 % after two, and 3.50 % after three. No run follows one that leaves all
/// odds below [`SCALE_ODDS`] and [`CAMERA_ODDS`]: in the red kitchen it would end at 3, and
/// `register` would take twice the time. Doubled, scans with wrong scales take up to twice as long.
pub const SCALE_RUNS: usize = 4;

/// Share of the errors of scales and focal lengths by which they may still change from run to run.
/// No unit. Chosen by hand: a scale that is taken for wrong is off by three standard deviations at
/// least, so a change is hardly more than a tenth of one. Measured in a kitchen of 31 frames: two
/// runs in place of four find the same scale within 0.8 % of its error, in half the time. Doubled,
/// the runs there are the same.
pub const SCALE_SETTLED: f64 = 0.02;
