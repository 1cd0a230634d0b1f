//! All integration tests, one binary:
//! - `exact`: the direct light at points, against a reference and closed forms.
//! - `kinks`: the lines on the receivers, held against the breaks of the light.
//! - `cli`: the program as a user runs it: exit codes, what it prints, what it writes.
//! - `bounced`: bounced light is what a path tracer finds.
//! - `budget`: budgets are kept, and what comes of them is told.
//! - `conform`: the lit meshes have no gaps, T-junctions or leaks.
//! - `corners`: the light between two walls, where it is known.
//! - `elements`: what the lines are worth.
//! - `form_factors`: of polygons and scenes, where they are known.
//! - `extremes`: stiff scenes and extreme ones.
//! - `furnace`: closed rooms lose no light.
//! - `golden`: pictures of lit fixtures stay what they are.
//! - `growth`: what a larger building costs.
//! - `honest`: the error asked for is the error found.
//! - `layering`: no stage of the library uses a later one.
//! - `lines`: the lines on the receivers, where closed forms say.
//! - `manufactured`: a solution that was chosen is found, and how fast.
//! - `metamorphic`: what must not change when the scene is turned, moved, scaled or reordered.
//! - `nasty`: scenes made of coincidences, whole.
//! - `punctual`: lights without a surface.
//! - `references`: the references that other tests trust, held against closed forms and against each other.
//! - `robust`: broken files are read, or refused in one line.
//! - `smooth`: facets of a curved surface are lit as the surface is, and do not show.
//! - `soup`: solids and faces in each other are lit once.
//! - `solvers`: every way to solve for the light between surfaces finds the same, and no power is lost.
//! - `textures`: what light sees of textures, and what the lit file holds of them.
//! - `traced`: bakes against a path tracer, as an error over all surfaces.

mod common;

mod bounced;
mod budget;
mod cli;
mod conform;
mod corners;
mod elements;
mod exact;
mod extremes;
mod form_factors;
mod furnace;
mod golden;
mod growth;
mod honest;
mod kinks;
mod layering;
mod lines;
mod manufactured;
mod metamorphic;
mod nasty;
mod punctual;
mod references;
mod robust;
mod smooth;
mod solvers;
mod soup;
mod textures;
mod traced;
