// Links and swings of an operation: their other ways, and to which of them a place of the axes belongs.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string_view>
#include <utility>

#include "config/table_home.h"
#include "daemon/plan/operation_plan.h"

namespace tiltfeed::daemon {
namespace {

/// Words further beside a move than this are not of it: under TCP blocks are joined. mm and degrees.
constexpr double kOffItsMove = 2.0;

}  // namespace

void OperationPlan::take_links() {
  if (!base_) return;
  planned_.path = *base_;
  planned_.report.rapid_length -= std::exchange(longer_, 0.0);
}

void OperationPlan::put_links() {
  limited_.reset();
  begins_.clear();
  if (!base_) {
    base_ = planned_.path;
    links_.assign(link_ways(*base_).size(), 0);
    swings_ = links_;
  }
  if (std::all_of(links_.begin(), links_.end(), [](std::size_t choice) { return choice == 0; })) return;
  stretched_ = with_links(*base_, links_, &begins_);
  // The CL file has no retract: there the link is as it was planned.
  std::vector<std::size_t> of_cl = links_;
  for (std::size_t& choice : of_cl)
    if (kLinkChoices[choice].at_retract) choice = 0;
  planned_.path = with_links(*base_, of_cl);
  longer_ = rapid_length(planned_.path) - rapid_length(*base_);
  planned_.report.rapid_length += longer_;
}

/// The tool can be taken off to the machine's retract, and the axes go from there as they are told.
bool OperationPlan::retracts() const {
  const config::ProgramFormat& format = job_.machine.format;
  // Such a control's table would turn to its place under TCP again.
  const bool turns_home = format.tcp && config::begins_at_home(format.dialect) &&
                          !config::table_turns(job_.machine.model).empty();
  return format.retract != "none" && !turns_home;
}

void OperationPlan::come_from(const std::optional<Joints>& from) {
  if (from == from_) return;
  from_ = from;
  if (!swings_.empty() && swings_.front() > 0) joints_known_ = false;
}

std::vector<std::size_t> OperationPlan::turns_back() const {
  std::vector<std::size_t> behind;
  const std::vector<std::uint32_t>& planned = joints_.planned;
  const std::size_t before = ends_.before ? 1 : 0;
  const bool as_planned = runs_.empty() && std::all_of(links_.begin(), links_.end(),
                                                       [](std::size_t choice) { return choice == 0; });
  for (std::size_t i = 1; as_planned && joints_.report.reconfigurations > 0 && i < planned.size(); ++i) {
    if (planned[i] != planned[i - 1] || planned[i] < before) continue;
    const std::size_t move = planned[i] - before;
    if (behind.empty() || behind.back() != move) behind.push_back(move);
  }
  return behind;
}

bool OperationPlan::turn_at_retract(const std::vector<std::size_t>& behind) {
  if (behind.empty() || !retracts() || behind.back() + 1 >= base_->moves.size()) return false;
  ToolPath path = *base_;
  path.moves.clear();
  std::vector<std::size_t> turns;  // moves of `path` in whose links a rotary turns
  auto feed = path.feeds.begin();
  auto next = behind.begin();
  for (std::size_t i = 0; i < base_->moves.size(); ++i) {
    for (; feed != path.feeds.end() && feed->move <= i; ++feed)
      feed->move = static_cast<std::uint32_t>(path.moves.size());
    const Move& move = base_->moves[i];
    path.moves.push_back(move);
    if (next == behind.end() || *next != i) continue;
    ++next;
    const bool off = move.kind != MoveKind::kCut, goes_off = base_->moves[i + 1].kind != MoveKind::kCut;
    turns.push_back(path.moves.size() - (off ? 1 : 0));
    if (off || goes_off) continue;
    const Pose& at = move.pose;
    path.moves.push_back(
        {{at.tip + at.axis * job_.plan.links.clearance, at.axis}, MoveKind::kRapid, kNoFacet});
    path.moves.push_back({at, MoveKind::kPlunge, move.facet});
  }
  const std::vector<LinkWay> ways = link_ways(path);
  turned_links_.clear();
  for (std::size_t i = 1; i + 1 < ways.size(); ++i)
    if (std::any_of(turns.begin(), turns.end(), [&](std::size_t move) { return ways[i].has(move); }))
      turned_links_.push_back(i);
  if (turned_links_.empty()) return false;
  base_ = std::move(path);
  links_.assign(ways.size(), 0);
  swings_ = links_;
  for (const std::size_t link : turned_links_) links_[link] = least_choice(link);
  joints_known_ = false;
  return true;
}

std::size_t OperationPlan::least_choice(std::size_t link) const {
  if (std::find(turned_links_.begin(), turned_links_.end(), link) == turned_links_.end()) return 0;
  const auto retract = std::find_if(kLinkChoices.begin(), kLinkChoices.end(),
                                    [](const LinkChoice& one) { return one.at_retract; });
  return static_cast<std::size_t>(retract - kLinkChoices.begin());
}

bool OperationPlan::link_differs(std::size_t link, std::size_t choice) const {
  if (!differs(*base_, link, choice)) return false;
  if (!kLinkChoices[choice].at_retract) return true;
  if (!retracts()) return false;
  // Between two planes there is one already.
  const LinkWay way = link_ways(*base_)[link];
  return !in_planes() || base_->moves[way.first - 1].pose.axis == base_->moves[way.last - 1].pose.axis;
}

bool OperationPlan::swing_differs(std::size_t link, std::size_t choice) const {
  if (link == 0)
    return from_ && retracts() && differs(job_.machine.model, job_.setup, *from_, usual_start_, choice);
  for (std::size_t i = 1; i < stretches_.size(); ++i)
    if (stretches_[i].link == link)
      return differs(job_.machine.model, job_.setup, joints_.moves[runs_[i - 1].last - 1].joints,
                     stretches_[i].usual, choice);
  return false;
}

/// A limit that stands at a link's move ("move 12, ..."): the way is chosen anew, or the program refused.
/// `first_link`: that of the path's beginning.
void OperationPlan::note_limit(const Error& error, const ToolPath& path, std::size_t first_link) {
  constexpr std::string_view kMove = "move ";
  if (error.code != Code::kLimit || !error.message.starts_with(kMove)) return;
  const std::size_t move = std::strtoull(error.message.c_str() + kMove.size(), nullptr, 10);
  const std::vector<LinkWay> ways = link_ways(path);
  for (std::size_t i = 0; i < ways.size(); ++i)
    if (ways[i].has(move)) limited_ = first_link + i;
}

std::optional<LinkPlace> OperationPlan::link_at(const Joints& words, bool rapid) const {
  const std::vector<JointMove>& moves = joints_.moves;
  const std::vector<LinkWay> ways = link_ways(block_path());
  const Joints up{0, 0, job_.machine.model.z.max, 0, 0};
  // How far beside a move they are, mm and degrees; whole turns are none.
  const auto off = [&](const Joints& p, const Joints& q) {
    const auto turned = [](double word, double from, double to) {
      const double turns = std::max(360.0, std::abs(to - from));
      return std::remainder(word - 0.5 * (from + to), turns) + 0.5 * (to - from);
    };
    const std::array<double, 5> way{q.x - p.x, q.y - p.y, q.z - p.z, q.a - p.a, q.c - p.c},
        at{words.x - p.x, words.y - p.y, words.z - p.z, turned(words.a, p.a, q.a), turned(words.c, p.c, q.c)};
    double square = 0.0, along = 0.0, least = 0.0;
    for (std::size_t i = 0; i < way.size(); ++i) square += way[i] * way[i], along += way[i] * at[i];
    const double share = square > 0.0 ? std::clamp(along / square, 0.0, 1.0) : 0.0;
    for (std::size_t i = 0; i < way.size(); ++i) least = std::max(least, std::abs(at[i] - share * way[i]));
    return least;
  };
  const auto raised = [&](Joints at) { return at.z = up.z, at; };
  std::size_t best = 0;  // of the moves
  double least = off(raised(moves.front().joints), moves.front().joints);
  const auto take = [&](std::size_t move, double apart) {
    if (apart < least) least = apart, best = move;
  };
  take(moves.size(), off(moves.back().joints, raised(moves.back().joints)));
  for (std::size_t i = 1; i < moves.size(); ++i)
    if ((moves[i].kind == MoveKind::kRapid) == rapid) take(i, off(moves[i - 1].joints, moves[i].joints));
  if (from_ && rapid) {
    Joints at = raised(*from_);
    double apart = std::numeric_limits<double>::infinity();
    for (const Joints& to :
         swing_places(job_.machine.model, at, raised(moves.front().joints), first_swing().way))
      apart = std::min(apart, off(at, to)), at = to;
    if (apart < least && apart <= kOffItsMove) return LinkPlace{0, true};
  }
  if (least > kOffItsMove) return std::nullopt;
  if (best == 0) return LinkPlace{};
  if (best == moves.size()) return LinkPlace{ways.size() - 1};
  const Joints &from = moves[best - 1].joints, &to = moves[best].joints;
  const bool in_run = std::any_of(runs_.begin(), runs_.end(),
                                  [&](const AxisRun& run) { return best >= run.first && best < run.last; });
  // Up to the retract the tool goes where the stretch has ended.
  const bool swings = !runs_.empty() && !in_run && raised(from) != raised(to);
  for (std::size_t i = 0; i < ways.size(); ++i)
    if (ways[i].has(moves[best].move)) return LinkPlace{i, swings};
  return std::nullopt;
}

std::size_t OperationPlan::link_near(Point<Part> tip) const {
  const std::vector<Move>& moves = block_path().moves;
  const std::vector<LinkWay> ways = link_ways(block_path());
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ways.size(); ++i)
    for (std::size_t k = std::max<std::size_t>(ways[i].first, 1); k < ways[i].last; ++k) {
      const double apart = distance_to_segment(tip, moves[k - 1].pose.tip, moves[k].pose.tip);
      if (apart < least) least = apart, best = i;
    }
  return best;
}

}  // namespace tiltfeed::daemon
