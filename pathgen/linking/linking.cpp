#include "pathgen/linking/linking.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "pathgen/envelope/heights.h"
#include "pathgen/linking/approach.h"
#include "pathgen/linking/closed_row.h"
#include "pathgen/linking/joins.h"
#include "pathgen/linking/leads.h"
#include "pathgen/linking/link_order.h"
#include "pathgen/linking/over_envelope.h"
#include "pathgen/linking/run_order.h"
#include "pathgen/linking/travel.h"
#include "pathgen/mesh/fresh_memory.h"

namespace tiltfeed::pathgen {

namespace {

/// Up, over in a few steps, down: for the memory to set aside.
constexpr std::size_t kMovesPerLink = 8;
/// Of the work, the passes slice by slice; another order finds most joins known.
constexpr double kPlainShare = 0.8;

/// A pass as it is travelled.
class Directed {
 public:
  Directed(const Pass& pass, bool reversed) : pass_(pass), reversed_(reversed) {}
  std::size_t size() const { return pass_.size(); }
  const EnvelopePoint& operator[](std::size_t i) const {
    return reversed_ ? pass_[pass_.size() - 1 - i] : pass_[i];
  }

 private:
  const Pass& pass_;
  bool reversed_;
};

/// Of all moves, about, s.
double seconds_of(const std::vector<Move>& moves, const Linking& options) {
  double cut = 0.0, plunged = 0.0;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    const double way = distance(moves[i - 1].pose.tip, moves[i].pose.tip);
    if (moves[i].kind != MoveKind::kRapid) (moves[i].kind == MoveKind::kCut ? cut : plunged) += way;
  }
  LinkTime::Options time;
  time.rapid = options.rapid, time.up = options.up;
  return LinkTime(time).of(moves) + (cut + plunged * options.plunge_ratio) / options.cut_speed;
}

class Linker {
 public:
  Linker(const ClField& field, const Linking& options, OppositeWall& opposite_wall, Envelope& envelope)
      : surface_(field.surface),
        options_(options),
        opposite_wall_(opposite_wall),
        travel_(field.deformation, options, opposite_wall,
                field.index.top() > options.clearance_z ? is_over(field, envelope, options.clearance)
                                                        : Travel::IsOver()),
        joins_(field, options, opposite_wall, envelope, travel_),
        leads_(field, options, opposite_wall, envelope, travel_),
        approaches_(field, options.approach, options.clearance_z) {
    if (options.leaned != nullptr)
      leaned_joins_.emplace(*options.leaned->field, options, opposite_wall, *options.leaned->envelope,
                            travel_);
  }

  Linked run(const Order& order, const std::vector<std::vector<Pass>>& slices, const ReportShare& report) {
    linked_ = {};
    down_.reset();
    chain_.reset(), pending_.clear(), wound_ = 0;
    turned_ = false;
    std::size_t points = 0;
    for (const Travelled& t : order) {
      const Pass& pass = slices[t.slice][t.pass];
      points += pass.size() + kMovesPerLink;
      if (goes_round(pass)) ++linked_.closed_rows;
    }
    rings_left_ = static_cast<int>(linked_.closed_rows);
    reserve_side_by_side(linked_.moves, points);
    Watch watch(report, order.size());
    for (const Travelled& t : order) {
      if (!watch.next()) break;
      const Pass& pass = slices[t.slice][t.pass];
      if (is_round(pass)) --rings_left_;
      if (go_on(pass)) continue;
      finish_ring();
      add({pass, sense(pass, t.reversed)});
    }
    finish_ring();
    if (down_) retract();
    return std::move(linked_);
  }

 private:
  static Travel::IsOver is_over(const ClField& field, Envelope& envelope, double clearance) {
    const auto coarse =
        std::make_shared<Envelope>(field.surface, field.deformation, field.index,
                                   far_over_options(field.surface, envelope.options(), clearance));
    return [&field, &envelope, coarse](Point<Flat> from, Point<Flat> to) {
      const auto is_clear = [&](Vec3 turn) {
        const Point<Flat> a = from + turn, b = to + turn;
        return !envelope.may_rise_over(line_between({a.x, a.y}, {b.x, b.y}), std::min(a.z, b.z)) ||
               far_over_envelope(field, *coarse, a, b) || over_envelope(field, envelope, a, b);
      };
      // The long way round may lie a turn on, where there are turns.
      const double x = field.deformation.period_x(), y = field.deformation.period_y();
      const int turns_x = x > 0.0 ? 1 : 0, turns_y = y > 0.0 ? 1 : 0;
      for (int i = -turns_x; i <= turns_x; ++i)
        for (int j = -turns_y; j <= turns_y; ++j)
          if (!is_clear({i * x, j * y, 0.0})) return false;
      return true;
    };
  }
  /// Requires: pass is not empty.
  void add(const Directed& pass) {
    if (is_shut_by_blank(pass[0]) || is_shut_by_blank(pass[pass.size() - 1])) {
      ++linked_.skipped_passes;
      return;
    }
    if (!join(pass) && !fly(pass)) return;
    for (std::size_t i = 1; i < pass.size(); ++i) cut(pass[i]);
    const EnvelopePoint& end = pass[pass.size() - 1];
    down_ = Down{{end, pass[pass.size() < 2 ? 0 : pass.size() - 2]}, &end};
    if (chain_) wound_ += *chain_ ? -1 : 1;
  }

  bool is_round(const Pass& pass) const {
    return options_.rounds > 1 && options_.leaned == nullptr && goes_round(pass);
  }

  /// (L9) From a closed row to the next without turning back, a turn long. That is cut as a row of its own
  /// only where the way does not go on from there likewise.
  bool go_on(const Pass& pass) {
    if (!down_ || !chain_ || !is_round(pass)) return false;
    const int sense = *chain_ ? -1 : 1;
    const bool zigzag = options_.direction == Direction::kZigzag;
    const int most = static_cast<int>(options_.rounds), out = wound_ * sense;
    if (!zigzag || (out + 2 <= most && out <= rings_left_)) {
      const Pass row = begun_near(pass, *chain_, down_->at.point.centre);
      if (const auto turn = joins_.round(down_->at.point, row)) {
        for (const EnvelopePoint& p : *turn) cut(p);
        cut(row[0]);
        ++linked_.joins;
        stand_at_end_of(row);
        pending_ = row;
        return true;
      }
    }
    finish_ring();
    const bool reversed = *chain_ != zigzag;
    const Pass row = begun_near(pass, reversed, down_->at.point.centre);
    if (!cut_join(joins_.between(down_->at, {row[0], row[1]}), row[0])) return false;
    chain_ = reversed;
    cut_ring(row);
    return true;
  }

  void cut_ring(const Pass& row) {
    for (std::size_t i = 1; i < row.size(); ++i) cut(row[i]);
    stand_at_end_of(row);
  }
  /// Of a closed row, which is where it begins.
  void stand_at_end_of(const Pass& row) {
    wound_ += *chain_ ? -1 : 1;
    down_ = Down{{row.front(), row[row.size() - 2]}, nullptr};
  }
  /// The row to which the way has gone on.
  void finish_ring() {
    if (pending_.empty()) return;
    cut_ring(pending_);
    pending_.clear();
  }

  /// Whether a pass is travelled backwards that an order wants so: behind closed rows that went on, the next
  /// begins at its nearer end.
  bool sense(const Pass& pass, bool reversed) {
    if (chain_ && down_ && options_.direction == Direction::kZigzag) {
      const Point<Part> at = down_->at.point.centre;
      turned_ = reversed != (distance(at, pass.back().centre) < distance(at, pass.front().centre));
    }
    reversed = reversed != turned_;
    chain_.reset();
    if (is_round(pass)) chain_ = reversed;
    return reversed;
  }

  /// Is what of the tool is beyond the column in the blank, there or on the way up?
  bool is_shut_by_blank(const EnvelopePoint& end) const {
    return options_.in_blank &&
           options_.in_blank(pose_of(end), travel_.pose({end.flat.x, end.flat.y, options_.clearance_z}));
  }

  /// (L5)
  bool join(const Directed& pass) {
    if (!down_ || options_.join_distance <= 0.0) return false;
    if (down_->end == nullptr)
      return cut_join(join_to({pass[0], pass[std::min<std::size_t>(1, pass.size() - 1)]}), pass[0]);
    const auto [known, unknown] = joined_.try_emplace({down_->end, &pass[0]});
    std::optional<Pass>& between = known->second;
    if (unknown) between = join_to({pass[0], pass[std::min<std::size_t>(1, pass.size() - 1)]});
    return cut_join(between, pass[0]);
  }

  bool cut_join(const std::optional<Pass>& between, const EnvelopePoint& to) {
    if (!between) return false;
    for (const EnvelopePoint& p : *between) cut(p);
    cut(to);
    ++linked_.joins;
    return true;
  }

  std::optional<Pass> join_to(const Joins::End& start) {
    const bool leans = leaned_joins_ && (leaned_end(down_->at.point) || leaned_end(start.point));
    if (!leans) return joins_.between(down_->at, start);
    const auto upright = [this](Joins::End end) {
      for (EnvelopePoint* p : {&end.point, &end.inward}) p->axis = travel_.pose(p->flat).axis;
      return end;
    };
    const std::optional<Pass> between = leaned_joins_->between(upright(down_->at), upright(start));
    return between ? options_.leaned->join(down_->at.point, *between, start.point) : std::nullopt;
  }

  std::optional<LeanedEnd> leaned_end(const EnvelopePoint& end) const {
    return options_.leaned != nullptr ? options_.leaned->end(end) : std::nullopt;
  }

  /// (L7) The same to a pass at whose start the tool leans.
  bool fly_leaning(const EnvelopePoint& start, const LeanedEnd& way) {
    const Travel::Way found = travel_to(way.over);
    if (found != Travel::Way::kFound) {
      ++(found == Travel::Way::kTilted ? linked_.tilted_passes : linked_.skipped_passes);
      return false;
    }
    push(pose_at(way.top, start.axis, options_.reference_height), MoveKind::kPlunge);
    const double over = options_.leaned->rapid_end(start);
    // What is known of the stock is along the axes of the field: along others the whole way is a plunge.
    if (!options_.free_from && over < distance(start.centre, way.top))
      push(pose_at(start.centre + start.axis * over, start.axis, options_.reference_height),
           MoveKind::kRapid);
    push(pose_of(start), MoveKind::kPlunge, surface_.facet_of(start.patch));
    count_lead(false);
    return true;
  }

  /// (L1) Up, over and down. Where there is no way, the pass is counted as left out, and the tool stays up.
  bool fly(const Directed& pass) {
    if (down_) retract();
    if (const auto leaned = leaned_end(pass[0])) return fly_leaning(pass[0], *leaned);
    std::vector<Point<Flat>> arc;
    if (options_.lead_radius > 0.0 && pass.size() > 1) arc = leads_.arc(pass[0], pass[1]);
    Travel::Way way = arc.empty() ? Travel::Way::kBlocked : travel_to(arc.back());
    if (way != Travel::Way::kFound) {
      arc.clear();
      way = travel_to(pass[0].flat);
    }
    if (way != Travel::Way::kFound) {
      ++(way == Travel::Way::kTilted ? linked_.tilted_passes : linked_.skipped_passes);
      return false;
    }
    const Point<Flat> foot = arc.empty() ? pass[0].flat : arc.back();
    double start = approaches_.rapid_end(foot);
    if (start < options_.clearance_z) start = opposite_wall_.rapid_end(foot, start);
    if (options_.free_from && start < options_.clearance_z) start = options_.free_from(foot, start);
    if (start < options_.clearance_z) push(travel_.pose({foot.x, foot.y, start}), MoveKind::kRapid);
    for (auto place = arc.rbegin(); place != arc.rend(); ++place)
      push(travel_.pose(*place), MoveKind::kPlunge);
    push(pose_of(pass[0]), MoveKind::kPlunge, surface_.facet_of(pass[0].patch));
    count_lead(!arc.empty());
    return true;
  }

  Travel::Way travel_to(Point<Flat> to) {
    if (linked_.moves.empty()) {
      const Pose over = travel_.pose({to.x, to.y, options_.clearance_z});
      if (options_.in_blank && options_.in_blank(over, over)) return Travel::Way::kBlocked;
      push(over, MoveKind::kRapid);
      return Travel::Way::kFound;
    }
    std::vector<Pose> poses;
    const Travel::Way way = travel_.find(at_, to, poses);
    if (way != Travel::Way::kFound) return way;
    for (const Pose& pose : poses)
      push(pose, opposite_wall_.rapid_clear(linked_.moves.back().pose, pose) ? MoveKind::kRapid
                                                                             : MoveKind::kPlunge);
    return way;
  }

  void retract() {
    if (const auto leaned = leaned_end(down_->at.point)) return retract_leaning(*leaned);
    std::vector<Point<Flat>> arc;
    if (options_.lead_radius > 0.0) arc = leads_.arc(down_->at.point, down_->at.inward);
    for (const Point<Flat>& place : arc) push(travel_.pose(place), MoveKind::kPlunge);
    at_ = arc.empty() ? down_->at.point.flat : arc.back();
    at_.z = options_.clearance_z;
    push(travel_.pose(at_), MoveKind::kRapid);
    count_lead(!arc.empty());
    ++linked_.retracts;
    down_.reset();
  }

  void retract_leaning(const LeanedEnd& way) {
    push(pose_at(way.top, down_->at.point.axis, options_.reference_height), MoveKind::kRapid);
    push(travel_.pose(way.over), MoveKind::kPlunge);
    at_ = way.over;
    count_lead(false);
    ++linked_.retracts;
    down_.reset();
  }

  void count_lead(bool placed) {
    if (options_.lead_radius <= 0.0) return;
    ++(placed ? linked_.leads : linked_.straight_ends);
  }
  Pose pose_of(const EnvelopePoint& p) const { return pose_at(p.centre, p.axis, options_.reference_height); }
  void cut(const EnvelopePoint& p) { push(pose_of(p), MoveKind::kCut, surface_.facet_of(p.patch)); }
  void push(const Pose& pose, MoveKind kind, std::uint32_t facet = kNoFacet) {
    if (kind != MoveKind::kCut && !linked_.moves.empty())
      linked_.air_length += distance(linked_.moves.back().pose.tip, pose.tip);
    linked_.moves.push_back({pose, kind, facet});
  }

  const ClSurface& surface_;
  const Linking& options_;
  OppositeWall& opposite_wall_;
  Travel travel_;
  Joins joins_;
  std::optional<Joins> leaned_joins_;  ///< where a pass may lean
  Leads leads_;
  Approaches approaches_;
  struct Down {
    Joins::End at;
    const EnvelopePoint* end;  ///< of the pass; null: of one that is not kept
  };
  std::optional<Down> down_;   ///< where a pass ended, while the tool is there
  std::optional<bool> chain_;  ///< the last pass is a closed row; whether it is travelled backwards
  Pass pending_;               ///< closed row at which the tool stands, not cut as such yet
  int rings_left_ = 0;         ///< closed rows that are still to be cut
  int wound_ = 0;              ///< turns of closed rows, forwards less backwards
  bool turned_ = false;        ///< passes that are not closed are travelled the other way than the order says
  /// From end to start; orders of the same passes share most.
  std::map<std::pair<const EnvelopePoint*, const EnvelopePoint*>, std::optional<Pass>> joined_;
  Point<Flat> at_;  ///< while it is on the clearance surface
  Linked linked_;
};

}  // namespace

Linked link(const std::vector<std::vector<Pass>>& slices, const ClField& field, const Linking& options,
            OppositeWall& opposite_wall, Envelope& envelope) {
  Linker linker(field, options, opposite_wall, envelope);
  const Order plain = plain_order(slices, options.direction);
  const bool one = options.order == PassOrder::kGiven;
  const ReportShare first = part_of(options.report, 0.0, one ? 1.0 : kPlainShare);
  const ReportShare second = part_of(options.report, kPlainShare, 1.0);
  Linked best = linker.run(plain, slices, first);
  if (one || (second && !second(0.0))) return best;
  const bool timed = options.order == PassOrder::kTimed;
  std::vector<Order> others{region_order(slices, field.deformation, options)};
  if (timed) others.push_back(timed_order(slices, field.deformation, options));
  const auto costs = [&](const Linked& l) { return timed ? seconds_of(l.moves, options) : l.air_length; };
  const auto left_out = [](const Linked& l) { return l.skipped_passes + l.tilted_passes; };
  for (std::size_t i = 0; i < others.size(); ++i) {
    const Order& order = others[i];
    if (order.empty() || order == plain) continue;
    const auto n = static_cast<double>(others.size()), at = static_cast<double>(i);
    Linked other = linker.run(order, slices, part_of(second, at / n, (at + 1.0) / n));
    if (left_out(other) < left_out(best) || (left_out(other) == left_out(best) && costs(other) < costs(best)))
      best = std::move(other);
  }
  return best;
}

}  // namespace tiltfeed::pathgen
