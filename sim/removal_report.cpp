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

PathDrawing draw_path(const std::string& folder, const Job& job, const CheckedMesh& part,
                      const ExecutedPath& path) {
  PictureOptions picture;
  picture.width = 1400, picture.height = 875;
  PathDrawing drawing{drawn_path(job, path), {}};
  drawing.written = draw_part_with_path(part.mesh, drawing.path, folder + "/path.png", picture);
  return drawing;
}

Result<void> write_removal_report(const std::string& folder, const RemovalContext& context,
                                  const PathDrawing& drawing, const Probes& probes, const Removal& removal,
                                  const RemovalVerdict& verdict) {
  if (!drawing.written) return drawing.written;
  const std::string at = folder + "/";
  const std::vector<ColourStop> scale = colour_scale(removal, verdict);
  std::array<Result<void>, 2> written;
  std::vector<Excerpt> lines;
  in_parallel(written.size(), static_cast<int>(written.size()), [&](std::size_t i) {
    if (i == 0) {
      written[i] =
          draw_deviation(context.part.mesh, drawing.path, probes, removal, scale, at + "deviation.png");
    } else {
      written[i] = write_file(at + "report.json", to_json(context, removal, verdict));
      lines = excerpts(context, worst_places(removal, verdict));
    }
  });
  for (const Result<void>& done : written)
    if (!done) return done;
  const PageParts parts{
      context, removal, verdict, scale, read_all(at + "deviation.png"), read_all(at + "path.png"), lines};
  return write_file(at + "index.html", removal_page(parts));
}

}  // namespace tiltfeed::sim
