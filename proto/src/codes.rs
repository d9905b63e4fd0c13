//! Enumerations of a result, each with its numbers on the wire and its names in JSON.

use std::fmt;

macro_rules! codes {
    ($($(#[doc = $doc:literal])* $own:ident { $($(#[doc = $own_doc:literal])* $code:literal $variant:ident $text:literal;)* })*) => {$(
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u32)]
        #[non_exhaustive]
        pub enum $own {
            $($(#[doc = $own_doc])* $variant = $code,)*
            /// A number that this version does not know.
            Unknown = u32::MAX,
        }

        impl $own {
            /// Every value but [`Self::Unknown`], in the order of the numbers.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// The number on the wire.
            #[must_use]
            pub const fn code(self) -> u32 {
                self as u32
            }

            /// The value of this number; [`Self::Unknown`] if there is none.
            #[must_use]
            pub const fn from_code(code: u32) -> Self {
                match code {
                    $($code => Self::$variant,)*
                    _ => Self::Unknown,
                }
            }

            /// The name used in JSON and logs; `unknown` for [`Self::Unknown`].
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)*
                    Self::Unknown => "unknown",
                }
            }
        }

        impl fmt::Display for $own {
            fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                to.pad(self.name())
            }
        }
    )*};
}

codes! {
    /// Which rule produced the fracture degree.
    DegreeOrigin {
        /// The threshold test: the object stays whole.
        0 Threshold "threshold";
        /// The calibrated closed form.
        1 ClosedForm "closed_form";
        /// The object's examples.
        2 Inferred "inferred";
        /// The object's examples, made to hold.
        3 Verified "verified";
        /// The full optimization.
        4 Optimized "optimised";
        /// The request.
        5 Forced "forced";
    }

    /// Requested source of the number of sites.
    DegreeMethod {
        /// From where the preset says; of requests that only aim.
        0 Preset "preset";
        /// The calibrated closed form.
        1 ClosedForm "closed_form";
        /// The full optimization.
        2 Optimized "optimised";
        /// The number in the request.
        3 Sites "sites";
        /// The object's examples, made to hold.
        4 Verified "verified";
        /// The object's examples.
        5 Inferred "inferred";
    }

    /// Source of the strain energy.
    EnergySource {
        /// A solve for the displacements, of one body at least.
        0 Solve "solve";
        /// The object's reduced basis.
        1 Reduced "reduced";
        /// The distance from the contacts: the effect `elastic` is off.
        2 Falloff "falloff";
        /// A bound: the object stays whole whatever the displacements are, so there are none.
        3 Bounded "bounded";
    }

    /// Criterion that stopped the computation.
    StopCriterion {
        /// Nothing: there was no diagram to refine.
        0 Complete "complete";
        /// The degree reached a cap.
        1 Capped "capped";
        /// The diagrams met their tolerance.
        2 Converged "converged";
        /// The diagrams met the error of the request.
        3 ErrorMet "error_met";
        /// The time of the request was over.
        4 Time "time";
        /// The diagrams took as many iterations as were allowed.
        5 Iterations "iterations";
    }

    /// Part that took most of the time when a time budget was exceeded.
    OverrunCause {
        /// The request waited in the queue.
        1 Queue "queue";
        /// A solve: the object has no reduced basis, or the request asked for a solve.
        2 NoReducedBasis "no_reduced_basis";
        /// A solve: the estimated error of the reduced displacements was too large.
        3 ReducedError "reduced_error";
        /// Energy and degree.
        4 Degree "degree";
        /// The cells, without an iteration.
        5 Cells "cells";
        /// The stages after the cells.
        6 AfterCells "after_cells";
    }

    /// Outer surface of the fragments.
    FragmentSurface {
        /// The boundary of the crack lattice, which approximates the input surface.
        0 Lattice "lattice";
        /// The input surface itself.
        1 Exact "exact";
    }

    /// Rule that decided whether the object breaks.
    FractureCriterion {
        /// The paper's: the first moment of the energy exceeds γ.
        0 Paper "paper";
        /// Strength and energy.
        1 Strength "strength";
    }

    /// A stage of the computation, in the order in which data flows.
    StageKind {
        /// Forces of the contacts.
        0 Load "load";
        /// Displacements and strain energy.
        1 Elasticity "elasticity";
        /// The test whether the object breaks.
        2 Threshold "threshold";
        /// The number of sites.
        3 Degree "degree";
        /// The centroidal Voronoi diagram.
        4 Centroidal "centroidal";
        /// A fragment for every lattice node.
        5 Labels "labels";
        /// Crack surfaces.
        6 Tessellation "tessellation";
        /// Closed meshes, masses and output effects.
        7 Fragments "fragments";
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_names_are_distinct_and_found_again() {
        fn check<T: Copy + PartialEq + fmt::Debug>(all: &[T], code: impl Fn(T) -> u32, back: impl Fn(u32) -> T) {
            for (place, own) in all.iter().enumerate() {
                assert_eq!(back(code(*own)), *own);
                assert_eq!(code(*own), code(all[0]) + place as u32, "numbers have no gaps");
            }
            assert!(!all.contains(&back(99)) && code(back(99)) == u32::MAX);
        }
        check(DegreeOrigin::ALL, DegreeOrigin::code, DegreeOrigin::from_code);
        check(DegreeMethod::ALL, DegreeMethod::code, DegreeMethod::from_code);
        check(EnergySource::ALL, EnergySource::code, EnergySource::from_code);
        check(StopCriterion::ALL, StopCriterion::code, StopCriterion::from_code);
        check(FragmentSurface::ALL, FragmentSurface::code, FragmentSurface::from_code);
        check(OverrunCause::ALL, OverrunCause::code, OverrunCause::from_code);
        check(FractureCriterion::ALL, FractureCriterion::code, FractureCriterion::from_code);
        check(StageKind::ALL, StageKind::code, StageKind::from_code);
        let mut names: Vec<&str> = StageKind::ALL.iter().map(|stage| stage.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!((names.len(), StageKind::Unknown.to_string()), (StageKind::ALL.len(), "unknown".to_owned()));
    }
}
