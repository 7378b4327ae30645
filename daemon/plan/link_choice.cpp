#include "daemon/plan/link_choice.h"

#include <algorithm>
#include <utility>

namespace tiltfeed::daemon {
namespace {

/// Axes that differ by less are one, as a chord.
constexpr double kOneAxis = 1e-9;
/// A path ends in a rapid of this length at least, mm.
constexpr double kEndsInRapid = 1.0;
/// A way that leaves the tool axis by less goes along it, mm.
constexpr double kAlong = 1e-6;

bool one_axis(const Pose& p, const Pose& q) { return length(p.axis - q.axis) < kOneAxis; }

Pose higher(const Pose& pose, double by) { return {pose.tip + pose.axis * by, pose.axis}; }

/// Whether `above` is further along the axis of `pose`, and of the same axis.
bool is_above(const Pose& above, const Pose& pose) {
  const Vec3 way = above.tip - pose.tip;
  const double up = dot(way, pose.axis);
  return one_axis(above, pose) && up >= 0.0 && length(way - pose.axis * up) < kAlong;
}

/// The moves of one link, anew.
class NewLink {
 public:
  NewLink(const ToolPath& path, const LinkWay& way, const LinkChoice& choice)
      : path_(path),
        way_(way),
        choice_(choice),
        along_(choice.at_feed ? MoveKind::kPlunge : MoveKind::kRapid) {}
  std::vector<Move> moves();
  /// Of these, the one behind the retract; 0: there is none.
  std::size_t begins() const { return begins_; }

 private:
  void put(const Pose& pose, MoveKind kind = MoveKind::kRapid) { out_.push_back({pose, kind, kNoFacet}); }
  const Pose& at(std::size_t move) const { return path_.moves[move].pose; }
  Pose over_last_cut() const;
  Pose over_next_cut() const;

  const ToolPath& path_;
  const LinkWay& way_;
  const LinkChoice& choice_;
  const MoveKind along_;  ///< off a cut and to it
  std::size_t begins_ = 0;
  std::vector<Move> out_;
};

/// Along the axis of the cut that ends.
Pose NewLink::over_last_cut() const {
  const Pose &cut = at(way_.first - 1), &first = at(way_.first);
  return higher(is_above(first, cut) ? first : cut, choice_.higher);
}

/// Along that of the next one, whose rapid ends with the link.
Pose NewLink::over_next_cut() const {
  const Pose& end = at(way_.last - 1);
  const bool comes_down = way_.last - way_.first > 1 && is_above(at(way_.last - 2), end);
  return higher(comes_down ? at(way_.last - 2) : end, choice_.higher);
}

std::vector<Move> NewLink::moves() {
  const auto planned = [&] {
    for (std::size_t i = way_.first; i < way_.last; ++i)
      put(at(i), choice_.higher > 0.0 ? along_ : path_.moves[i].kind);
  };
  if (way_.first == way_.last || (choice_.higher == 0.0 && !choice_.at_retract))
    return planned(), std::move(out_);
  if (way_.first == 0) {
    put(higher(at(0), choice_.higher));
    return planned(), std::move(out_);
  }
  if (way_.last == path_.moves.size()) {
    planned();
    put(higher(at(way_.last - 1), choice_.higher), along_);
    if (choice_.at_feed) put(higher(out_.back().pose, kEndsInRapid));
    return std::move(out_);
  }
  const Pose from = over_last_cut(), to = over_next_cut();
  put(from, along_);
  if (choice_.at_retract) {
    if (choice_.at_feed) put(higher(from, kEndsInRapid));
    begins_ = out_.size();
  } else if (choice_.turn == LinkTurn::kOnTheWay) {
    for (std::size_t i = way_.first; i < way_.last; ++i)
      if (const Pose next = higher(at(i), choice_.higher); next != out_.back().pose)
        put(next, path_.moves[i].kind);
  } else {
    put(choice_.turn == LinkTurn::kBehind ? Pose{to.tip, from.axis} : Pose{from.tip, to.axis});
  }
  if (choice_.at_retract || to != out_.back().pose) put(to);
  put(at(way_.last - 1), along_);
  return std::move(out_);
}

}  // namespace

std::vector<LinkWay> link_ways(const ToolPath& path) {
  const std::size_t count = path.moves.size();
  const auto kind = [&](std::size_t i) { return path.moves[i].kind; };
  std::size_t begin = 0;
  std::vector<LinkWay> links;
  for (std::size_t i = 0; i <= count; ++i) {
    if (i < count && kind(i) != MoveKind::kCut) continue;
    // From `begin` to before i nothing cuts.
    LinkWay way{begin, begin, begin, i};
    for (std::size_t k = begin; k < i; ++k) {
      if (kind(k) != MoveKind::kRapid) continue;
      if (way.first == way.last) way.first = k;
      way.last = k + 1;
    }
    const bool end = begin == 0 || i == count;
    if (way.first != way.last || end) links.push_back(way);
    begin = i + 1;
  }
  return links;
}

bool differs(const ToolPath& path, std::size_t link, std::size_t choice) {
  const bool turns = kLinkChoices[choice].turn != LinkTurn::kOnTheWay;
  if (!turns && !kLinkChoices[choice].at_retract) return true;
  const LinkWay way = link_ways(path)[link];
  return way.first > 0 && way.last < path.moves.size() &&
         !(turns && one_axis(path.moves[way.first - 1].pose, path.moves[way.last - 1].pose));
}

ToolPath with_links(const ToolPath& path, const std::vector<std::size_t>& choices,
                    std::vector<std::size_t>* begins) {
  ToolPath out{path.name, path.tool, path.cut_feed, path.plunge_feed, {}, {}};
  const std::vector<LinkWay> links = link_ways(path);
  auto feed = path.feeds.begin();
  // A feed that changes within a link holds from the next move that is kept on.
  const auto put_feeds = [&](std::size_t move) {
    for (; feed != path.feeds.end() && feed->move <= move; ++feed) {
      const auto at = static_cast<std::uint32_t>(out.moves.size());
      if (!out.feeds.empty() && out.feeds.back().move == at) out.feeds.pop_back();
      out.feeds.push_back({at, feed->feed});
    }
  };
  std::size_t at = 0;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const LinkWay& way = links[i];
    for (; at < way.first; ++at) put_feeds(at), out.moves.push_back(path.moves[at]);
    if (way.first == way.last) continue;
    put_feeds(way.first);
    NewLink link(path, way, kLinkChoices[choices[i]]);
    const std::size_t before = out.moves.size();
    for (const Move& move : link.moves()) out.moves.push_back(move);
    if (begins != nullptr && link.begins() > 0) begins->push_back(before + link.begins());
    at = way.last;
  }
  for (; at < path.moves.size(); ++at) put_feeds(at), out.moves.push_back(path.moves[at]);
  return out;
}

double rapid_length(const ToolPath& path) {
  double all = 0.0;
  for (const LinkWay& way : link_ways(path))
    for (std::size_t i = std::max<std::size_t>(way.first, 1); i < way.last; ++i)
      all += distance(path.moves[i - 1].pose.tip, path.moves[i].pose.tip);
  return all;
}

}  // namespace tiltfeed::daemon
