#include "sim/path_check/path_check.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sim/basics/workers.h"
#include "sim/motion/forward.h"
#include "sim/path_check/executed.h"
#include "sim/path_check/path_check_judge.h"
#include "sim/path_check/path_matching.h"
#include "sim/solid/tool_solid.h"

namespace tiltfeed::sim {
namespace {

// Blocks whose poses are held in memory at a time, and blocks that a thread takes at a time: fixed, so that
// the report does not depend on the number of threads.
constexpr std::size_t kBatchBlocks = 32768;
constexpr std::size_t kChunkBlocks = 2048;
// Drops are counted in bins for their percentile; beyond the last bin there is nothing under the tool.
constexpr double kDropBin = 1e-4, kMaxDrop = 5.0;
constexpr auto kDropBins = static_cast<std::size_t>(kMaxDrop / kDropBin);
// Above this the surface winds round the point: inside.
constexpr double kInside = 0.5;

/// One block of a batch with its poses.
struct Sampled {
  std::size_t block = 0;  ///< index into the executed blocks
  std::vector<Pose> poses;
  std::vector<std::uint32_t> moves;  ///< planned move of each pose
};

/// What one thread finds against the part.
struct Findings {
  std::array<Extreme, 3> gouge;  ///< by kToolParts
  Extreme rapid_overlap, gap, drop;
  std::uint64_t samples = 0, cut_samples = 0, air_samples = 0;
  std::vector<std::uint32_t> drops;
};

void keep_larger(Extreme& kept, const Extreme& other) {
  if (other.value > kept.value) kept = other;
}

class Verifier {
 public:
  Verifier(const config::Job& job, const pathgen::Mesh& part, const std::vector<Block>& program,
           const ToolPath& planned, const std::vector<TraceRow>& trace, const PathCheckOptions& options)
      : job_(job),
        mesh_(part),
        planned_(planned),
        trace_(trace),
        options_(options),
        part_(part),
        walk_(planned),
        blocks_(executed_blocks(trace)),
        tool_(job.plan.cutter, {job.plan.allowance, job.plan.radial_stock, job.plan.axial_stock}),
        inner_(job.plan.cutter.radius()) {
    // The program's way from an unknown place is not the path's; nor is that to and from its retract.
    std::vector<bool> placed;
    for (const Block& block : program) {
      if (block.op != Op::kRapid && block.op != Op::kFeed) continue;
      placed.push_back(block.placed), off_path_.push_back(block.off_path);
    }
    const auto before = std::min(std::count(placed.begin(), placed.end(), false), std::ssize(blocks_));
    blocks_.erase(blocks_.begin(), blocks_.begin() + before);
    off_path_.erase(off_path_.begin(), off_path_.begin() + std::min(before + 1, std::ssize(off_path_)));
    report_.tolerance = options.tolerance > 0.0 ? options.tolerance : job.plan.tolerance;
    report_.axis_tolerance = options.axis_tolerance;
    const double least = tool_.narrowest();
    sampling_ = {options.samples_per_block, options.max_step > 0.0 ? options.max_step : least / 4.0,
                 tool_.top()};
    // Steps below half the least radius cannot jump across the surface unseen: see judge_start.
    sampling_.max_step = std::min(sampling_.max_step, least / 2.0);
  }

  Result<void> run(const pathgen::Progress& progress);
  PathCheckReport report(const std::vector<Block>& program);

 private:
  void sample(std::vector<Sampled>& batch) const;
  void follow(std::vector<Sampled>& batch);
  void measure(const Sampled& block, Findings& found) const;
  void measure_contact(const Pose& pose, const TracePlace& place, std::uint32_t& hint, Findings& found) const;
  void judge_start(const Pose& start);
  void collect_missed();
  bool off_path(std::size_t block) const { return block < off_path_.size() && off_path_[block]; }
  TracePlace place_of(const Sampled& block, std::size_t i) const;
  std::uint32_t source_of(std::uint32_t facet) const {
    return facet < mesh_.source.size() ? mesh_.source[facet] : facet;
  }

  const config::Job& job_;
  const pathgen::Mesh& mesh_;
  const ToolPath& planned_;
  const std::vector<TraceRow>& trace_;
  const PathCheckOptions& options_;
  PartDistance part_;
  PathMatching walk_;
  std::vector<ExecutedBlock> blocks_;
  std::vector<bool> off_path_;  ///< by block: it goes to or comes from the retract
  ToolSolid tool_;
  double inner_;  ///< height over the tip of a point inside the tool, mm
  Sampling sampling_;
  Pose at_;
  std::uint32_t move_ = 0;  ///< planned move of the last pose on the path
  std::vector<std::uint64_t> drops_ = std::vector<std::uint64_t>(kDropBins + 1, 0);
  PathCheckReport report_;
};

TracePlace Verifier::place_of(const Sampled& block, std::size_t i) const {
  const TraceRow& row = trace_[blocks_[block.block].to];
  return {row.block, row.command.line, block.moves.empty() ? 0 : block.moves[i], kNoFacet,
          block.poses[i].tip};
}

void Verifier::sample(std::vector<Sampled>& batch) const {
  in_parallel((batch.size() + kChunkBlocks - 1) / kChunkBlocks, options_.threads, [&](std::size_t chunk) {
    const std::size_t end = std::min(batch.size(), (chunk + 1) * kChunkBlocks);
    for (std::size_t i = chunk * kChunkBlocks; i < end; ++i) {
      const ExecutedBlock& block = blocks_[batch[i].block];
      batch[i].poses.clear();
      sample_block(job_.machine.model, job_.setup, trace_[block.from].command.target,
                   trace_[block.to].command.target, sampling_, batch[i].poses);
    }
  });
}

/// Walks along the planned path; notes each pose's move, the deviations and the lengths.
void Verifier::follow(std::vector<Sampled>& batch) {
  for (Sampled& block : batch) {
    block.moves.assign(block.poses.size(), move_);
    const bool away = off_path(block.block),
               back = block.block + 1 < blocks_.size() && !off_path(block.block + 1);
    const bool rapid = trace_[blocks_[block.block].to].command.op == Op::kRapid;
    for (std::size_t i = 0; i < block.poses.size(); ++i) {
      if (away && !(back && i + 1 == block.poses.size())) {
        report_.rapid_length += distance(at_.tip, block.poses[i].tip);
        at_ = block.poses[i];
        continue;
      }
      const PathPlace at = walk_.step(block.poses[i]);
      block.moves[i] = move_ = at.move;
      const TracePlace place = place_of(block, i);
      keep_larger(rapid ? report_.rapid_deviation : report_.tip_deviation, {at.distance, place});
      if (!rapid) keep_larger(report_.axis_deviation, {Angle::from_radians(at.angle).degrees(), place});
      const double way = distance(at_.tip, block.poses[i].tip);
      const MoveKind kind = planned_.moves[at.move].kind;
      (rapid                    ? report_.rapid_length
       : kind == MoveKind::kCut ? report_.cut_length
                                : report_.plunge_length) += way;
      at_ = block.poses[i];
    }
  }
}

void Verifier::measure(const Sampled& block, Findings& found) const {
  const bool rapid = trace_[blocks_[block.block].to].command.op == Op::kRapid;
  std::uint32_t hint = kNoFacet;
  for (std::size_t i = 0; i < block.poses.size(); ++i) {
    const Pose& pose = block.poses[i];
    for (const ToolPart part : kToolParts) {
      Extreme& deepest = rapid ? found.rapid_overlap : found.gouge[static_cast<int>(part)];
      // Only what is deeper than the deepest so far is of interest: that bounds the search.
      const Hit hit = tool_.clearance(part_, pose, part, -deepest.value);
      if (hit.facet == kNoFacet) continue;
      deepest = {-hit.value, place_of(block, i)};
      deepest.place.facet = source_of(hit.facet), deepest.place.tool = part;
    }
    ++found.samples;
    if (!rapid && planned_.moves[block.moves[i]].kind == MoveKind::kCut)
      measure_contact(pose, place_of(block, i), hint, found);
  }
}

void Verifier::measure_contact(const Pose& pose, const TracePlace& place, std::uint32_t& hint,
                               Findings& found) const {
  const Hit drop = tool_.drop(part_, pose, kMaxDrop, hint);
  ++found.cut_samples;
  ++found.drops[std::min(kDropBins, static_cast<std::size_t>(drop.value / kDropBin))];
  if (drop.facet != kNoFacet) hint = drop.facet;
  Extreme dropped{drop.value, place}, gap{drop.value, place};
  dropped.place.facet = gap.place.facet = drop.facet == kNoFacet ? kNoFacet : source_of(drop.facet);
  keep_larger(found.drop, dropped);
  // The gap is never larger than the drop.
  if (drop.value <= std::min(found.gap.value, report_.tolerance)) return;
  const Hit near = tool_.gap(part_, pose);
  gap.value = std::max(0.0, near.value);
  if (gap.value > report_.tolerance) ++found.air_samples;
  gap.place.facet = source_of(near.facet);
  keep_larger(found.gap, gap);
}

/// Where the motion starts decides for all of it: between two samples no point of the tool moves more than
/// half its least radius, so to get from outside to inside its axis would have to come nearer to the surface
/// than that, and such a gouge is found.
void Verifier::judge_start(const Pose& start) {
  const Point<Part> centre = start.tip + start.axis * inner_;
  if (part_.winding_number(centre) <= kInside) return;
  const TraceRow& row = trace_[blocks_.front().from];
  report_.rapid_overlap = {
      tool_.cutting().widest(),
      {row.block, row.command.line, 0, source_of(part_.nearest(centre).facet), start.tip}};
}

Result<void> Verifier::run(const pathgen::Progress& progress) {
  if (mesh_.facets.empty()) return fail(Code::kInput, "verify: the part has no facets");
  if (blocks_.empty())
    return fail(Code::kInput, "verify: the trace has no motion after its first block; was the program run?");
  at_ = forward_by_frames(job_.machine.model, job_.setup, trace_[blocks_.front().from].command.target);
  if (!off_path(0)) walk_.step(at_);
  judge_start(at_);
  std::vector<Sampled> batch;
  for (std::size_t begin = 0; begin < blocks_.size(); begin += kBatchBlocks) {
    if (progress && !progress("verify", static_cast<double>(begin) / static_cast<double>(blocks_.size())))
      return fail(Code::kCancelled, "verification was cancelled");
    batch.resize(std::min(kBatchBlocks, blocks_.size() - begin));
    for (std::size_t i = 0; i < batch.size(); ++i) batch[i].block = begin + i;
    sample(batch);
    follow(batch);
    const std::size_t chunks = (batch.size() + kChunkBlocks - 1) / kChunkBlocks;
    std::vector<Findings> findings(chunks);
    in_parallel(chunks, options_.threads, [&](std::size_t chunk) {
      findings[chunk].drops.assign(kDropBins + 1, 0);
      const std::size_t end = std::min(batch.size(), (chunk + 1) * kChunkBlocks);
      for (std::size_t i = chunk * kChunkBlocks; i < end; ++i) measure(batch[i], findings[chunk]);
    });
    for (const Findings& f : findings) {
      for (std::size_t i = 0; i < f.gouge.size(); ++i) {
        keep_larger(report_.gouge_by[i], f.gouge[i]);
        keep_larger(report_.gouge, f.gouge[i]);
      }
      keep_larger(report_.rapid_overlap, f.rapid_overlap);
      keep_larger(report_.gap, f.gap), keep_larger(report_.drop, f.drop);
      report_.samples += f.samples, report_.cut_samples += f.cut_samples;
      report_.air_samples += f.air_samples;
      for (std::size_t b = 0; b <= kDropBins; ++b) drops_[b] += f.drops[b];
    }
  }
  if (progress) progress("verify", 1.0);
  return {};
}

/// Every planned end of a feed move must have been visited.
void Verifier::collect_missed() {
  for (std::size_t m = 0; m < planned_.moves.size(); ++m) {
    const bool feed = planned_.moves[m].kind != MoveKind::kRapid;
    if (feed && walk_.visited()[m] > report_.missed_point.value)
      report_.missed_point = {
          walk_.visited()[m],
          {0, 0, static_cast<std::uint32_t>(m), planned_.moves[m].facet, planned_.moves[m].pose.tip}};
  }
}

PathCheckReport Verifier::report(const std::vector<Block>& program) {
  report_.program = compare_blocks(program, trace_);
  report_.seconds = trace_.back().end - trace_[blocks_.front().from].end;
  report_.peaks = axis_peaks(trace_);
  collect_missed();
  std::uint64_t above = 0;
  std::size_t bin = kDropBins + 1;
  while (bin > 0 && above + drops_[bin - 1] <= report_.cut_samples / 1000) above += drops_[--bin];
  report_.drop_999 = std::min(report_.drop.value, static_cast<double>(bin) * kDropBin);
  judge(report_);
  return report_;
}

}  // namespace

Result<PathCheckReport> check_path(const config::Job& job, const pathgen::Mesh& part,
                                   const std::vector<Block>& program, const ToolPath& planned,
                                   const std::vector<TraceRow>& trace, const PathCheckOptions& options,
                                   const pathgen::Progress& progress) {
  if (planned.moves.empty())
    return fail(Code::kInput, "verify: the planned path has no points; plan the job again");
  Verifier verifier(job, part, program, planned, trace, options);
  if (auto done = verifier.run(progress); !done) return tl::unexpected(done.error());
  return verifier.report(program);
}

}  // namespace tiltfeed::sim
