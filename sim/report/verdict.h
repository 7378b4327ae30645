#pragma once
// The verdict on a removal run.

#include <string>
#include <vector>

#include "config/job.h"
#include "sim/removal/removal.h"
#include "sim/report/program_header.h"

namespace tiltfeed::sim {

/// What the moves were read from.
enum class Source { kProgram, kTrace, kCanon };

/// What was verified with what.
struct RemovalContext {
  const config::Job& job;
  const pathgen::CheckedMesh& part;
  StockShape stock;
  std::string source;  ///< the program's or trace's file
  ProgramHeader header;
  Source kind = Source::kProgram;
  std::string stock_from = "";  ///< why this stock, where nobody gave it
};

struct RemovalVerdict {
  double tolerance = 0.0;             ///< mm
  double gouge = 0.0;                 ///< deepest cut of feed moves into the part, tolerated ones too, mm
  double excess_limit = 0.0;          ///< of the median of what is left, mm
  std::vector<std::string> failures;  ///< one line each: value, limit, place
  /// What the resolution is too coarse to see, and which one would; empty: nothing.
  std::string unseen;
  std::string rest;  ///< what is missing where nothing is wrong but the program is not complete
  bool passed() const { return failures.empty() && rest.empty(); }
  bool incomplete() const { return failures.empty() && !rest.empty(); }
  /// "passed", "incomplete", "FAILED".
  const char* word() const { return passed() ? "passed" : incomplete() ? "incomplete" : "FAILED"; }
};

/// The tool's part, depth, block, line, place and facet.
std::string trouble_text(const Trouble& trouble);

/// Share of the surface that is cut or could be; less is what rows leave at their ends.
inline constexpr double kLeastRest = 0.002;
/// Does the operation cut all that it reaches? Not with pencil passes, nor with `rest`.
bool asks_all(const pathgen::PlanOptions& plan);
/// What may be left where the job's passes lie side by side, mm; the cutter's radius where it asks for less
/// than all.
double rest_limit(const pathgen::PlanOptions& plan);
/// What failed and what is missing. Nothing touched at all fails, too.
/// Properties: 1 A trouble of any kind fails. 2 A feed move that asks for more at the tip than any feed of
/// the job fails. 3 Another number of blocks than the header states fails. 4 More than rest_limit() on half
/// of the surface that was touched fails. 5 Incomplete: more than kLeastRest of the surface is reached by the
/// tool and has more left than the limit.
RemovalVerdict judge(const Removal& removal, const RemovalContext& context);

}  // namespace tiltfeed::sim
