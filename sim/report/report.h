#pragma once
// The verdict on a removal run, and the report of it: JSON, pictures, one page for people.

#include <memory>
#include <string>
#include <vector>

#include "config/job.h"
#include "sim/removal/removal.h"
#include "sim/report/program_header.h"
#include "sim/report/verdict.h"

namespace tiltfeed::sim {

/// The report as JSON, keys with units, indented; the same bytes for the same run.
std::string to_json(const RemovalContext& context, const Removal& removal, const RemovalVerdict& verdict);

/// The folder is made if it is absent. Errors: kIo: that cannot be, or nothing can be written into it.
Result<void> make_report_folder(const std::string& folder);

class DeviationPicture;
/// What the report shows whatever is removed.
struct Drawings {
  Result<std::string> path;  ///< the path's picture: the bytes of a PNG file; kIo
  std::shared_ptr<DeviationPicture> deviation;
};

/// Asks nothing of the removal, and may be drawn meanwhile.
Drawings draw_report(const config::Job& job, const pathgen::CheckedMesh& part, const ExecutedPath& path,
                     const Patches& patches);

/// What the report says.
struct RemovalFindings {
  const RemovalContext& context;
  const Drawings& drawings;
  const Removal& removal;
  const RemovalVerdict& verdict;
  const ExecutedPath& path;
  const Probes& probes;
  const StockFilm* film;  ///< null: none
};

/// Writes report.json, index.html, path.png, deviation.png and cut.view into the folder, or the page alone
/// where `out` ends in .html, when all is made: what ends before leaves no part of a report. Errors: kIo,
/// that of the drawings, too.
Result<void> write_removal_report(const std::string& out, const RemovalFindings& findings, int threads);
/// Is that the page alone?
bool is_page(const std::string& out);

}  // namespace tiltfeed::sim
