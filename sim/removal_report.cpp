#include "sim/removal_report.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "sim/forward.h"
#include "sim/picture.h"
#include "sim/removal_page.h"
#include "sim/removal_picture.h"
#include "sim/workers.h"

namespace tiltfeed::sim {
namespace {

constexpr std::uint32_t kLinesRound = 3;  // of the program before and after a place's line

Result<void> write_file(const std::string& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  if (!(out << bytes << std::flush)) return fail(Code::kIo, path + ": cannot be written");
  return {};
}

std::string read_all(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

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

Result<void> write_removal_report(const std::string& folder, const RemovalContext& context,
                                  const ExecutedPath& path, const Probes& probes, const Removal& removal,
                                  const RemovalVerdict& verdict) {
  const std::string at = folder + "/";
  if (auto written = write_file(at + "report.json", to_json(context, removal, verdict)); !written)
    return written;
  const ToolPath drawn = drawn_path(context.job, path);
  const std::vector<ColourStop> scale = colour_scale(removal, verdict);
  PictureOptions picture;
  picture.width = 1400, picture.height = 875;
  std::array<Result<void>, 2> drawings;
  in_parallel(drawings.size(), static_cast<int>(drawings.size()), [&](std::size_t i) {
    drawings[i] = i == 0
                      ? draw_deviation(context.part.mesh, drawn, probes, removal, scale, at + "deviation.png")
                      : draw_part_with_path(context.part.mesh, drawn, at + "path.png", picture);
  });
  for (const Result<void>& done : drawings)
    if (!done) return done;
  const PageParts parts{context,
                        removal,
                        verdict,
                        scale,
                        read_all(at + "deviation.png"),
                        read_all(at + "path.png"),
                        excerpts(context, worst_places(removal, verdict))};
  return write_file(at + "index.html", removal_page(parts));
}

}  // namespace tiltfeed::sim
