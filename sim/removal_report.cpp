#include "sim/removal_report.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>

#include "sim/forward.h"
#include "sim/picture.h"
#include "sim/removal_page.h"
#include "sim/removal_picture.h"
#include "sim/workers.h"

namespace tiltfeed::sim {
namespace {

constexpr std::uint32_t kLinesRound = 3;  // of the program before and after a place's line

/// What the pictures draw: the poses at the moves' ends.
ToolPath drawn_path(const Job& job, const ExecutedPath& path) {
  ToolPath drawn;
  const FrameChain chain(job.machine.model, job.setup);
  const auto add = [&](const Joints& joints, bool rapid) {
    drawn.moves.push_back({chain(joints), rapid ? MoveKind::kRapid : MoveKind::kCut, kNoFacet});
  };
  drawn.moves.reserve(path.moves.size() + 1);
  add(path.start, true);
  for (const ExecutedMove& move : path.moves) add(move.to, move.rapid);
  return drawn;
}

/// What a line of the source is known by: in a program its N word, or the count of lines; in a trace its
/// block; the number of a canonical command.
std::uint64_t number_of(const std::string& line, std::uint64_t count, Source kind) {
  if (kind != Source::kProgram) return std::strtoull(line.c_str(), nullptr, 10);
  if (line.size() < 2 || (line[0] != 'N' && line[0] != 'n')) return count;
  return std::strtoull(line.c_str() + 1, nullptr, 10);
}

std::vector<Excerpt> excerpts(const RemovalContext& context, const std::vector<WorstPlace>& places) {
  std::vector<Excerpt> found(places.size());
  if (places.empty()) return found;
  std::multimap<std::uint64_t, std::size_t> wanted;
  for (std::size_t i = 0; i < places.size(); ++i)
    wanted.insert({context.kind == Source::kTrace ? places[i].block : places[i].line, i});
  std::ifstream in(context.source, std::ios::binary);
  std::vector<std::string> before;
  std::vector<std::pair<std::size_t, std::uint32_t>> open;  // place, lines still wanted
  std::string line;
  for (std::uint64_t count = 1; std::getline(in, line); ++count) {
    while (!line.empty() && line.back() == '\r') line.pop_back();
    for (auto& [place, left] : open) found[place].lines.push_back(line), --left;
    std::erase_if(open, [](const auto& o) { return o.second == 0; });
    const auto [from, to] = wanted.equal_range(number_of(line, count, context.kind));
    for (auto at = from; at != to; ++at) {
      Excerpt& excerpt = found[at->second];
      if (!excerpt.lines.empty()) continue;
      excerpt.lines = before, excerpt.marked = before.size();
      excerpt.lines.push_back(line);
      open.push_back({at->second, kLinesRound});
    }
    before.push_back(line);
    if (before.size() > kLinesRound) before.erase(before.begin());
  }
  return found;
}

}  // namespace

Result<void> make_report_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(Code::kIo, folder + ": the folder cannot be made: " + error.message());
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    return fail(Code::kIo, folder + ": nothing can be written there: " + std::strerror(errno));
  return {};
}

Drawings draw_report(const Job& job, const CheckedMesh& part, const ExecutedPath& path,
                     const Patches& patches) {
  PictureOptions picture;
  picture.width = 1400, picture.height = 875;
  const ToolPath drawn = drawn_path(job, path);
  Drawings drawings{part_with_path(part.mesh, drawn, picture), {}};
  drawings.deviation = std::make_shared<DeviationPicture>(part.mesh, drawn, patches);
  return drawings;
}

Result<void> write_removal_report(const std::string& folder, const RemovalContext& context,
                                  const Drawings& drawings, const Removal& removal,
                                  const RemovalVerdict& verdict, int threads) {
  if (!drawings.path) return tl::unexpected(drawings.path.error());
  const std::vector<ColourStop> scale = colour_scale(removal, verdict);
  Result<std::string> deviation;
  std::string json;
  std::vector<Excerpt> lines;
  in_parallel(2, threads, [&](std::size_t i) {
    if (i == 0)
      deviation = drawings.deviation->png(removal, scale, threads);
    else
      json = to_json(context, removal, verdict), lines = excerpts(context, worst_places(removal, verdict));
  });
  if (!deviation) return tl::unexpected(deviation.error());
  const std::string page =
      removal_page({context, removal, verdict, scale, *deviation, *drawings.path, lines});
  const std::array<std::pair<const char*, const std::string*>, 4> files{{{"path.png", &*drawings.path},
                                                                         {"deviation.png", &*deviation},
                                                                         {"report.json", &json},
                                                                         {"index.html", &page}}};
  for (const auto& [name, bytes] : files)
    if (auto written = write_bytes(folder + "/" + name, *bytes); !written) return written;
  return {};
}

}  // namespace tiltfeed::sim
