#include "sim/removal_report.h"

#include <algorithm>
#include <array>
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

constexpr std::uint32_t kLinesRound = 3;  // of the program before and after a trouble's line

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

/// The number that the program gives a line: its N word, or the count of lines.
std::uint32_t number_of(const std::string& line, std::uint32_t count) {
  if (line.size() < 2 || (line[0] != 'N' && line[0] != 'n')) return count;
  const unsigned long number = std::strtoul(line.c_str() + 1, nullptr, 10);
  return static_cast<std::uint32_t>(number);
}

std::vector<Excerpt> excerpts(const std::string& program, const std::vector<Trouble>& troubles) {
  std::vector<Excerpt> found(troubles.size());
  if (troubles.empty()) return found;
  std::multimap<std::uint32_t, std::size_t> wanted;
  for (std::size_t i = 0; i < troubles.size(); ++i) wanted.insert({troubles[i].line, i});
  std::ifstream in(program, std::ios::binary);
  std::vector<std::string> before;
  std::vector<std::pair<std::size_t, std::uint32_t>> open;  // trouble, lines still wanted
  std::string line;
  for (std::uint32_t count = 1; std::getline(in, line); ++count) {
    while (!line.empty() && line.back() == '\r') line.pop_back();
    for (auto& [trouble, left] : open) found[trouble].lines.push_back(line), --left;
    std::erase_if(open, [](const auto& o) { return o.second == 0; });
    const auto [from, to] = wanted.equal_range(number_of(line, count));
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

Result<void> write_removal_report(const std::string& folder, const RemovalContext& context,
                                  const ExecutedPath& path, const Probes& probes, const Removal& removal,
                                  const RemovalVerdict& verdict) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(Code::kIo, folder + ": the folder cannot be made: " + error.message());
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
                        excerpts(context.source, removal.troubles)};
  return write_file(at + "index.html", removal_page(parts));
}

}  // namespace tiltfeed::sim
