#include "daemon/plan/avoidance.h"

#include <algorithm>
#include <utility>

#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

using Operations = std::vector<std::unique_ptr<OperationPlan>>;

/// How the operations are planned.
struct Variant {
  std::vector<int> tilts;                         ///< preferred, by operation
  std::vector<std::vector<std::size_t>> choices;  ///< of their links
  std::vector<std::vector<std::size_t>> swings;   ///< likewise
};

/// A link of an operation, or its swing.
struct PlaceOf {
  std::size_t operation = 0;
  LinkPlace at;

  bool operator==(const PlaceOf&) const = default;
};

class Attempts {
 public:
  Attempts(const Operations& operations, const AvoidanceCalls& calls, const PlanListener& told)
      : operations_(operations), calls_(calls), told_(told) {}
  Result<void> run(std::optional<Avoidance>& avoidance);

 private:
  Result<void> attempt(const Variant& variant, const char* said);
  std::optional<Variant> other_tilt() const;
  Variant chosen() const;
  /// No rotary turns back with the tool taken off: there the ways are made with the joints.
  bool may_change() const;
  std::vector<int> sides() const;
  std::string why(const Result<void>& failed) const;
  Result<void> try_links(std::optional<Variant> next);
  std::optional<Variant> turning_at_retract(const std::vector<std::vector<std::size_t>>& turns);
  std::optional<Variant> other_links();
  std::optional<Variant> other_links(const std::vector<PlaceOf>& places, bool all);
  std::string what_was_tried() const;

  const Operations& operations_;
  const AvoidanceCalls& calls_;
  const PlanListener& told_;
  std::size_t attempts_ = 0;
  std::string turned_, linked_;  ///< why these did not serve; empty: they were not tried
  bool turns_stay_ = false;      ///< the tool is taken off to turn a rotary, and there is no retract for that
  bool links_tried_ = false, swings_tried_ = false, retract_tried_ = false;
  std::vector<PlaceOf> changed_;  ///< by the last of other_links()
  bool no_joints_ = false;        ///< with them
  std::string cut_;               ///< a collision that is in no link
};

Result<void> Attempts::attempt(const Variant& variant, const char* said) {
  told_.say(std::string("bodies come too near to each other; ") + said);
  for (std::size_t i = 0; i < operations_.size(); ++i) {
    operations_[i]->prefer_tilt(variant.tilts[i]);
    operations_[i]->choose_links(variant.choices[i], variant.swings[i]);
  }
  ++attempts_;
  Result<void> done = calls_.once();
  no_joints_ = !done && (done.error().code == Code::kLimit || done.error().code == Code::kUnreachable);
  return done;
}

Variant Attempts::chosen() const {
  Variant now;
  for (const auto& one : operations_) {
    now.tilts.push_back(one->preferred_tilt());
    now.choices.push_back(one->link_choices());
    now.swings.push_back(one->swing_choices());
  }
  return now;
}

/// Nothing where no tilt leans.
std::optional<Variant> Attempts::other_tilt() const {
  Variant other = chosen();
  bool leans = false;
  for (std::size_t i = 0; i < operations_.size(); ++i)
    if (const int side = operations_[i]->tilt_side(); side != 0) other.tilts[i] = -side, leans = true;
  return leans ? std::optional(other) : std::nullopt;
}

bool Attempts::may_change() const {
  return std::none_of(operations_.begin(), operations_.end(),
                      [](const auto& one) { return one->joints().report.reconfigurations > 0; });
}

std::vector<int> Attempts::sides() const {
  std::vector<int> all;
  for (const auto& one : operations_) all.push_back(one->tilt_side());
  return all;
}

std::string Attempts::why(const Result<void>& failed) const {
  const ProofProcess* const prover = calls_.prover();
  const bool collides = prover != nullptr && !prover->collision().empty();
  const std::string& text = collides ? prover->collision() : failed.error().message;
  return text.substr(0, text.find(';'));  // without the worst place, or what to do
}

/// The next choice that makes another way; false: there is none.
bool next_choice(const OperationPlan& plan, std::vector<std::size_t>& choices, std::size_t link) {
  std::size_t& choice = choices[link];
  while (++choice < kLinkChoices.size())
    if (plan.link_differs(link, choice)) return true;
  return false;
}

bool next_swing(const OperationPlan& plan, std::vector<std::size_t>& swings, std::size_t link) {
  for (std::size_t choice = swings[link] + 1; choice < kSwingChoices.size(); ++choice)
    if (plan.swing_differs(link, choice)) {
      swings[link] = choice;
      return true;
    }
  return false;
}

/// `all`: more links may collide than are told, so that none stays behind these.
std::optional<Variant> Attempts::other_links(const std::vector<PlaceOf>& places, bool all) {
  Variant next = chosen();
  std::size_t most = 0;
  for (const auto& [operation, at] : places) {
    const OperationPlan& plan = *operations_[operation];
    std::vector<std::size_t>&links = next.choices[operation], &swings = next.swings[operation];
    if (!at.swing && next_choice(plan, links, at.link)) {
      most = std::max(most, links[at.link]);
      continue;
    }
    // A link has another way with the tilt on its other side.
    if (!next_swing(plan, swings, at.link)) return std::nullopt;
    if (!at.swing) links[at.link] = plan.least_choice(at.link);
  }
  const std::size_t operation = places.front().operation;
  std::vector<std::size_t>& choices = next.choices[operation];
  for (std::size_t i = 0; all && i < choices.size(); ++i) {
    const std::size_t before = choices[i];
    while (choices[i] < most && next_choice(*operations_[operation], choices, i)) continue;
    if (choices[i] >= kLinkChoices.size()) choices[i] = before;
  }
  changed_ = places;
  return next;
}

/// Other ways for the links and swings that the last attempt failed at. Nothing: it did not fail at these, or
/// there are none left.
std::optional<Variant> Attempts::other_links() {
  if (!may_change()) return std::nullopt;
  for (std::size_t i = 0; i < operations_.size(); ++i)
    if (const auto limited = operations_[i]->limited_link()) {
      const PlaceOf swing{i, {*limited, true}};
      const bool swung = std::find(changed_.begin(), changed_.end(), swing) != changed_.end();
      return other_links({swung ? swing : PlaceOf{i, {*limited}}}, false);
    }
  if (no_joints_ && !changed_.empty()) return other_links(std::vector(changed_), false);
  const ProofProcess* const prover = calls_.prover();
  if (prover == nullptr) return std::nullopt;
  if (const auto& gouge = prover->gouge(); gouge && gouge->operation < operations_.size())
    return other_links({{gouge->operation, {operations_[gouge->operation]->link_near(gouge->tip)}}}, false);
  const std::vector<CollisionFound>& found = prover->places();
  if (found.empty() || found.front().operation >= operations_.size()) return std::nullopt;
  const std::size_t operation = found.front().operation;
  std::vector<PlaceOf> places;
  for (const CollisionFound& place : found) {
    if (place.operation != operation) continue;
    const auto link = operations_[operation]->link_at(place.words, place.rapid);
    if (!link) {
      cut_ = "line " + std::to_string(place.line) + ": " + place.bodies;
      return std::nullopt;
    }
    if (std::find(places.begin(), places.end(), PlaceOf{operation, *link}) == places.end())
      places.push_back({operation, *link});
  }
  return other_links(places, found.size() >= ProofProcess::kMostTold);
}

/// From `next` on, until one is proven, or no other way is left.
Result<void> Attempts::try_links(std::optional<Variant> next) {
  Result<void> done = fail(Code::kInput, "");
  for (std::size_t i = 0; next && i < kMostLinkAttempts; ++i) {
    for (const std::vector<std::size_t>& swings : next->swings)
      for (const std::size_t choice : swings) swings_tried_ = swings_tried_ || choice > 0;
    for (const std::vector<std::size_t>& links : next->choices)
      for (const std::size_t choice : links) {
        links_tried_ = links_tried_ || choice > 0;
        retract_tried_ = retract_tried_ || kLinkChoices[choice].at_retract;
      }
    done = attempt(*next, "rapids between the cuts are tried on other ways");
    if (done || done.error().code == Code::kCancelled) return done;
    linked_ = why(done);
    next = other_links();
  }
  return done;
}

/// Where the tool is taken off to turn a rotary, it goes to the machine's retract. `turns`: of each
/// operation, behind which moves.
std::optional<Variant> Attempts::turning_at_retract(const std::vector<std::vector<std::size_t>>& turns) {
  for (std::size_t i = 0; i < operations_.size(); ++i)
    if (!turns[i].empty() && !operations_[i]->turn_at_retract(turns[i])) {
      turns_stay_ = true;
      return std::nullopt;
    }
  return chosen();
}

std::string Attempts::what_was_tried() const {
  std::string text;
  const auto add = [&](const std::string& what) { text += (text.empty() ? "; tried, too: " : "; ") + what; };
  if (!turned_.empty()) add("the tilt on its other side (" + turned_ + ")");
  if (links_tried_) {
    const auto by_height = [](const LinkChoice& a, const LinkChoice& b) { return a.higher < b.higher; };
    const double most = std::max_element(kLinkChoices.begin(), kLinkChoices.end(), by_height)->higher;
    add("rapids between the cuts higher by up to " + decimal(most, 0) +
        " mm along the tool, turning on the way, behind it and before it" +
        (retract_tried_ ? ", and by way of the retract" : ""));
  }
  if (swings_tried_)
    add("swings at the retract with the axes in another order, the other way round and with the tilt on its "
        "other side");
  if (!linked_.empty()) text += " (at last: " + linked_ + ")";
  if (turns_stay_)
    add("nothing else: the tool is taken off to turn a rotary (K11), which cannot be at the retract, as the "
        "profile states none or the control's table turns home under TCP first");
  if (!cut_.empty()) text += "; no other rapid between cuts helps at " + cut_;
  return text;
}

Result<void> Attempts::run(std::optional<Avoidance>& avoidance) {
  const Result<void> first = calls_.once();
  const ProofProcess* const prover = calls_.prover();
  const std::string collision = first || prover == nullptr ? "" : prover->collision();
  if (first || collision.empty()) return first;
  const std::vector<int> before = sides();
  const auto over = other_tilt();
  const bool turns_back = !may_change();
  const Variant planned = chosen();
  std::vector<std::vector<std::size_t>> turns;
  for (const auto& one : operations_) turns.push_back(one->turns_back());
  auto links = other_links();  // none where a rotary turns back
  Result<void> done = first;
  const auto settled = [&] { return done || done.error().code == Code::kCancelled; };
  bool turned = false;
  std::optional<Variant> links_over;
  if (over) {
    done = attempt(*over, "the tilt is tried on its other side");
    // The same sides again are the same program.
    turned = sides() != before;
    if (!done && done.error().code == Code::kCancelled) return done;
    if (!done && turned) turned_ = why(done), links_over = other_links();
    if (done && !turned) done = first;
  }
  if (!settled() && links) done = try_links(links), turned = false;
  if (!settled() && links_over) done = try_links(links_over), turned = true;
  // The last, as it puts links into the paths.
  if (!settled() && turns_back) {
    for (std::size_t i = 0; i < operations_.size(); ++i) operations_[i]->prefer_tilt(planned.tilts[i]);
    links = turning_at_retract(turns);
    if (links) done = try_links(links), turned = false;
  }
  if (!done && done.error().code == Code::kCancelled) return done;
  if (!done) return fail(first.error().code, first.error().message + what_was_tried());
  avoidance = Avoidance{collision, turned, {}, {}, attempts_};
  for (const auto& one : operations_)
    for (std::size_t i = 0; i < one->link_choices().size(); ++i) {
      if (const std::size_t choice = one->link_choices()[i]; choice > 0)
        avoidance->links.push_back({one->job().operation.name, i, kLinkChoices[choice]});
      if (const std::size_t choice = one->swing_choices()[i]; choice > 0)
        avoidance->swings.push_back({one->job().operation.name, i, kSwingChoices[choice]});
    }
  return done;
}

}  // namespace

std::string avoidance_text(const Avoidance& avoidance) {
  std::string text;
  const auto add = [&](const std::string& what) { text += (text.empty() ? "" : ", and ") + what; };
  if (!avoidance.links.empty()) {
    double most = 0.0;
    std::size_t turns = 0, retracts = 0;
    for (const AvoidedLink& one : avoidance.links) {
      most = std::max(most, one.choice.higher);
      turns += one.choice.turn != LinkTurn::kOnTheWay;
      retracts += one.choice.at_retract;
    }
    const std::size_t count = avoidance.links.size(), higher = count - retracts;
    if (higher > 0)
      add(std::to_string(higher) + (higher == 1 ? " rapid way goes" : " rapid ways go") +
          " higher along the tool, by up to " + decimal(most, 0) + " mm" +
          (turns == 0 ? "" : ", " + std::to_string(turns) + " turning over a cut"));
    if (retracts > 0)
      add(std::to_string(retracts) + (retracts == 1 ? " rapid way goes" : " rapid ways go") +
          " by way of the retract");
  }
  if (const std::size_t count = avoidance.swings.size(); count > 0)
    add(std::to_string(count) + (count == 1 ? " swing at the retract goes" : " swings at the retract go") +
        " another way");
  if (!text.empty() && !avoidance.other_side) text += ". As planned first these come too near: ";
  if (avoidance.other_side)
    add("the tilt stands on its other side. On the side that was taken first these come too near: ");
  return text + avoidance.collision;
}

Result<void> avoid_collisions(const Operations& operations, const AvoidanceCalls& calls,
                              const PlanListener& told, std::optional<Avoidance>& avoidance) {
  return Attempts(operations, calls, told).run(avoidance);
}

}  // namespace tiltfeed::daemon
