#include "daemon/plan/engaged_feeds.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::daemon {
namespace {

// Two measurements of one load differ by what the spans lie elsewhere: the next attempt keeps so much below.
constexpr double kBelow = 0.995;
// Loads within this share over the limit are on it: the table's last digit.
constexpr double kOnLimit = 1e-4;

/// From rows of a table to spans in seconds of the joints that the program was made from.
class SpanClock {
 public:
  SpanClock(const JointPath& joints, const JointPath& words) : words_(words) {
    double at = 0.0;
    std::vector<double> passed;
    for (const JointMove& move : joints.moves) passed.push_back(at += move.seconds);
    for (std::size_t i = 0; i < words.moves.size(); ++i)
      ends_.push_back(passed[std::min(words.ends.empty() ? i : words.ends[i], passed.size() - 1)]);
  }

  LoadSpan span(const EngagedRow& row) const {
    LoadSpan span{at(row.first_behind, row.first_share),
                  at(row.last_behind, row.last_share),
                  row.way,
                  row.chip,
                  row.edge_load,
                  row.turn_load};
    if (row.took > 0.0) span.pace = std::min(1.0, row.asked / row.took);
    for (std::uint64_t behind = row.last_behind; behind <= row.first_behind; ++behind)
      if (const JointMove* move = block(behind); move == nullptr || move->kind != MoveKind::kCut)
        span.cut = false;
    return span;
  }

 private:
  const JointMove* block(std::uint64_t behind) const {
    return behind < words_.moves.size() ? &words_.moves[words_.moves.size() - 1 - behind] : nullptr;
  }
  double at(std::uint64_t behind, double share) const {
    if (behind >= ends_.size()) return 0.0;
    const std::size_t index = ends_.size() - 1 - behind;
    const double before = index > 0 ? ends_[index - 1] : 0.0;
    return before + share * (ends_[index] - before);
  }

  const JointPath& words_;
  std::vector<double> ends_;
};

std::vector<LoadSpan> spans_of(const OperationPlan& plan, const PlannedProgram& posted, std::size_t index,
                               const std::vector<EngagedRow>& rows) {
  const SpanClock clock(plan.joints(), *posted.posting.operations[index].words);
  std::vector<LoadSpan> spans;
  spans.reserve(rows.size());
  for (const EngagedRow& row : rows) spans.push_back(clock.span(row));
  return spans;
}

/// (FE2) The way of a turn of the spindle, and that on which the slides brake.
double way_ahead(const config::Job& job) {
  const double feed = job.feeds.highest.mm_per_min(), per_second = feed / 60.0;
  const MachineModel& m = job.machine.model;
  const double slowest = std::min({m.x.acceleration, m.y.acceleration, m.z.acceleration});
  return (job.spindle_rpm > 0.0 ? feed / job.spindle_rpm : 0.0) +
         (slowest > 0.0 ? per_second * per_second / (2.0 * slowest) : 0.0);
}

FeedRule rule_of(const config::Job& job) {
  const double own = job.plan.cut_feed.mm_per_min();
  return {std::max(1.0, job.feeds.highest.mm_per_min() / own),
          std::min(1.0, job.feeds.lowest.mm_per_min() / own), job.feeds.change, way_ahead(job)};
}

/// Of the largest loads at the job's own feeds the share that each may have.
Loads limits_of(const config::Job& job, const Loads& before) {
  const double load = job.feeds.load, chip = job.feeds.largest_chip;
  const bool bound = chip > 0.0 && before.chip > 0.0;
  return {bound ? std::min(load, chip / before.chip) : load, load, load};
}

double share_of(double now, double before) { return before > 0.0 ? now / before : now > 0.0 ? 2.0 : 0.0; }

}  // namespace

Result<void> feeds_can_follow(const std::vector<const OperationPlan*>& operations) {
  bool any = false;
  for (const OperationPlan* one : operations) {
    const config::Job& job = one->job();
    const std::string where = job.path + ": --optimise feed ";
    if (one->in_planes())
      return fail(Code::kInput, where + "does not go with tilted planes: state program.tilted_planes: false");
    if (one->in_stretches())
      return fail(Code::kInput, where +
                                    "does not go with rapids by way of the retract, which keep bodies "
                                    "apart here: plan without it");
    if (job.machine.format.inches)
      return fail(Code::kInput, where + "does not go with program.units: inch: plan with a profile in mm");
    if (job.program.arc_tolerance > 0.0)
      return fail(Code::kInput, where + "does not go with arcs: leave out program.arc_tolerance_mm");
    any =
        any || job.feeds.highest > job.plan.cut_feed || job.feeds.load < 1.0 || job.feeds.largest_chip > 0.0;
  }
  if (any) return {};
  return fail(
      Code::kInput,
      operations.front()->job().path +
          ": --optimise feed has nothing to change: no operation states "
          "feeds.highest_mm_per_min over its cut_mm_per_min, nor a load_percent below 100, and no tool's "
          "cutting data state largest_chip_mm or highest_feed_per_tooth_mm");
}

double seconds_on_link(const config::MachineProfile& machine, const ProgramReport& program) {
  if (machine.link_rate <= 0.0 || program.blocks == 0) return 0.0;
  return static_cast<double>(program.bytes) / static_cast<double>(program.blocks) / machine.link_rate;
}

EngagedFeeds::EngagedFeeds(std::vector<OperationPlan*> operations, const PlannedProgram& posted,
                           const MeasuredEngagement& before) {
  for (std::size_t i = 0; i < operations.size(); ++i) {
    One one{operations[i], spans_of(*operations[i], posted, i, before.rows[i])};
    one.before = largest_loads(one.spans);
    operations_.push_back(std::move(one));
    found_.push_back({true, before.seconds[i], before.seconds[i], operations[i]->joints().moves.size(),
                      operations_.back().before.edge_load > 0.0 ? Loads{1.0, 1.0, 1.0} : Loads{}});
  }
}

void EngagedFeeds::apply(double least_seconds) {
  for (One& one : operations_) {
    const config::Job& job = one.plan->job();
    const Loads share = limits_of(job, one.before);
    const Loads limits = Loads{one.before.chip * share.chip, one.before.edge_load * share.edge_load,
                               one.before.turn_load * share.turn_load}
                             .times(one.margin);
    one.plan->run_at(one.given_up ? std::vector<SpeedStep>{} : feed_profile(one.spans, limits, rule_of(job)),
                     least_seconds);
  }
}

bool EngagedFeeds::holds(const PlannedProgram& posted, const MeasuredEngagement& now) {
  ++tried_;
  bool all = true;
  for (std::size_t i = 0; i < operations_.size(); ++i) {
    One& one = operations_[i];
    if (one.given_up) continue;
    FollowedFeeds& found = found_[i];
    const Loads loads = largest_loads(spans_of(*one.plan, posted, i, now.rows[i]));
    found.share = {share_of(loads.chip, one.before.chip), share_of(loads.edge_load, one.before.edge_load),
                   share_of(loads.turn_load, one.before.turn_load)};
    found.seconds = now.seconds[i], found.kept = false;
    const Loads limit = limits_of(one.plan->job(), one.before);
    const double over = std::max({found.share.chip / limit.chip, found.share.edge_load / limit.edge_load,
                                  found.share.turn_load / limit.turn_load});
    const bool slower = limit.chip >= 1.0 && limit.edge_load >= 1.0 && found.seconds >= found.seconds_before;
    if (over <= 1.0 + kOnLimit && !slower) continue;
    all = false;
    one.margin *= kBelow / std::max(over, 1.0);
    if (!slower && tried_ < kTries) continue;
    one.given_up = true;
    if (limit.chip < limit.edge_load)
      one.plan->warn(
          "no feed keeps every chip under the largest_chip_mm of the tool's cutting data: the job's own "
          "feeds stay, and make chips " +
          std::to_string(1.0 / limit.chip) + " times as thick");
    found.kept = true, found.seconds = found.seconds_before, found.share = {1.0, 1.0, 1.0};
  }
  return all;
}

}  // namespace tiltfeed::daemon
