#pragma once
// The proof's figures in the header of a program: filled in when all is written and held.

#include <string>
#include <string_view>

#include "config/output_file.h"
#include "daemon/plan/proof_process.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// The header's word on the proof; the figures take its place, no longer than it.
inline constexpr std::string_view kNotProvenYet = "proof of this program is still to be made";
inline constexpr std::string_view kNoProof = "no proof, as --no-proof says";

/// The program's first bytes, as they are written; the word on the proof is in them.
std::string head_of(config::OutputFile& file);
/// Puts the figures where the header says that they are still to come. Errors: kIo: it does not say so, or
/// the disk.
Result<void> state_figures(config::OutputFile& file, const ProofFigures& figures);

}  // namespace tiltfeed::daemon
