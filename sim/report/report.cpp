#include "sim/report/report.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>

#include "config/output_file.h"
#include "sim/basics/workers.h"
#include "sim/motion/forward.h"
#include "sim/picture/picture.h"
#include "sim/report/cut_view.h"
#include "sim/report/deviation_picture.h"
#include "sim/report/report_page.h"

namespace tiltfeed::sim {
namespace {

constexpr std::uint32_t kLinesRound = 3;  // of the program before and after a place's line

/// What the pictures draw: the poses at the moves' ends.
ToolPath drawn_path(const config::Job& job, const ExecutedPath& path) {
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
std::uint64_t number_of(std::string_view line, std::uint64_t count, Source kind) {
  if (kind == Source::kProgram) {
    if (line.size() < 2 || (line[0] != 'N' && line[0] != 'n')) return count;
    line.remove_prefix(1);
  }
  line.remove_prefix(std::min(line.size(), line.find_first_not_of(" \t")));
  std::uint64_t number = 0;
  std::from_chars(line.data(), line.data() + line.size(), number);
  return number;
}

/// The lines of a file, without their ends: LF, CR LF, or CR alone.
class SourceLines {
 public:
  explicit SourceLines(const std::string& path) {
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    text_.resize(in ? static_cast<std::size_t>(std::max<std::streamoff>(0, in.tellg())) : 0);
    in.seekg(0);
    in.read(text_.data(), static_cast<std::streamsize>(text_.size()));
    left_ = std::string_view(text_).substr(0, static_cast<std::size_t>(in.gcount()));
  }
  std::optional<std::string_view> next() {
    if (left_.empty()) return std::nullopt;
    const std::size_t end = std::min(left_.find_first_of("\r\n"), left_.size());
    const std::string_view line = left_.substr(0, end);
    left_.remove_prefix(end);
    left_.remove_prefix(left_.starts_with("\r\n") ? 2 : std::min<std::size_t>(1, left_.size()));
    return line;
  }

 private:
  std::string text_;
  std::string_view left_;
};

std::vector<Excerpt> excerpts(const RemovalContext& context, const std::vector<WorstPlace>& places) {
  std::vector<Excerpt> found(places.size());
  if (places.empty()) return found;
  std::multimap<std::uint64_t, std::size_t> wanted;
  for (std::size_t i = 0; i < places.size(); ++i)
    wanted.insert({context.kind == Source::kTrace ? places[i].block : places[i].line, i});
  SourceLines lines(context.source);
  std::deque<std::string_view> before;
  std::vector<std::pair<std::size_t, std::uint32_t>> open;  // place, lines still wanted
  std::uint64_t count = 1;
  for (auto line = lines.next(); line; line = lines.next(), ++count) {
    for (auto& [place, left] : open) found[place].lines.emplace_back(*line), --left;
    std::erase_if(open, [](const auto& o) { return o.second == 0; });
    const auto [from, to] = wanted.equal_range(number_of(*line, count, context.kind));
    for (auto at = from; at != to; ++at) {
      Excerpt& excerpt = found[at->second];
      if (!excerpt.lines.empty()) continue;
      excerpt.lines.assign(before.begin(), before.end()), excerpt.marked = before.size();
      excerpt.lines.emplace_back(*line);
      open.push_back({at->second, kLinesRound});
    }
    before.push_back(*line);
    if (before.size() > kLinesRound) before.pop_front();
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

Drawings draw_report(const config::Job& job, const pathgen::CheckedMesh& part, const ExecutedPath& path,
                     const Patches& patches) {
  PictureOptions picture;
  picture.width = 1400, picture.height = 875;
  const ToolPath drawn = drawn_path(job, path);
  Drawings drawings{part_with_path(part.mesh, drawn, picture), {}};
  drawings.deviation = std::make_shared<DeviationPicture>(part.mesh, drawn, patches);
  return drawings;
}

bool is_page(const std::string& out) { return out.ends_with(".html"); }

Result<void> write_removal_report(const std::string& out, const RemovalFindings& f, int threads) {
  if (!f.drawings.path) return tl::unexpected(f.drawings.path.error());
  const std::vector<ColourStop> scale = colour_scale(f.removal, f.verdict);
  Result<std::string> deviation;
  std::string json, view;
  std::vector<Excerpt> lines;
  in_parallel(2, threads, [&](std::size_t i) {
    if (i == 0) {
      deviation = f.drawings.deviation->png(f.removal, scale, threads);
    } else {
      json = to_json(f.context, f.removal, f.verdict);
      lines = excerpts(f.context, worst_places(f.removal, f.verdict));
      view = cut_view({f.context, f.removal, f.verdict, f.path, f.probes, f.film, scale, lines});
    }
  });
  if (!deviation) return tl::unexpected(deviation.error());
  const std::string page =
      report_page({f.context, f.removal, f.verdict, scale, *deviation, *f.drawings.path, lines, view});
  std::vector<std::pair<std::string, const std::string*>> files;
  if (is_page(out))
    files = {{out, &page}};
  else
    files = {{out + "/path.png", &*f.drawings.path},
             {out + "/deviation.png", &*deviation},
             {out + "/report.json", &json},
             {out + "/cut.view", &view},
             {out + "/index.html", &page}};
  std::vector<config::OutputFile> outputs;
  for (const auto& [name, bytes] : files) {
    auto file = config::OutputFile::open(name);
    if (!file) return tl::unexpected(file.error());
    file->stream() << *bytes;
    outputs.push_back(std::move(*file));
  }
  return config::OutputFile::commit_all(outputs);
}

}  // namespace tiltfeed::sim
