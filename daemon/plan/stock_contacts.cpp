#include "daemon/plan/stock_contacts.h"

#include <algorithm>
#include <optional>

#include "daemon/plan/formatted.h"
#include "pathgen/tool/blank_solid.h"

namespace tiltfeed::daemon {
namespace {

bool has_shank(const pathgen::Cutter& cutter) { return cutter.shank_length > cutter.cutting_end(); }

bool may_meet(const OperationPlan& one) {
  const pathgen::Cutter& cutter = one.job().plan.cutter;
  return has_shank(cutter) || !cutter.holder.empty();
}

/// What the first operation cuts from; nothing: nobody knows.
std::optional<pathgen::BlankSolid> stock_of(const OperationPlan& first,
                                            const std::vector<const OperationPlan*>& all) {
  if (first.job().operation.number != 1) return std::nullopt;
  if (const auto& blank = first.job().plan.blank) return *blank;
  const bool asked = std::any_of(
      all.begin(), all.end(), [](const OperationPlan* one) { return one->job().plan.rest_more_than > 0.0; });
  if (!asked || first.job().plan.pattern.kind != pathgen::PatternKind::kRough) return std::nullopt;
  return pathgen::BlankSolid::box(first.part().bounds);
}

pathgen::ToolMoves moves_of(const OperationPlan& one) {
  return {&one.job().plan.cutter, &one.block_path().moves, one.job().plan.tolerance};
}

std::string advice(const pathgen::PlanOptions& plan, bool shank) {
  std::string text = shank ? "use longer flutes (cutter.cutting_length_mm)"
                           : "use a tool that sticks out further (cutter.shank_length_mm)";
  if (shank && plan.cutter.shank_radius() > plan.cutter.cutting_top_radius())
    text += ", a narrower shank";
  else if (!shank)
    text += ", a narrower holder";
  if (shank && plan.pattern.step_down > plan.cutter.cutting_end()) text += ", a smaller pattern.step_down_mm";
  if (plan.pattern.kind != pathgen::PatternKind::kRough) text += ", an operation before that roughs there";
  return text + ", or an axis that leans the tool away from it";
}

std::string warning(const pathgen::PlanOptions& plan, const pathgen::StockContact& found, bool shank) {
  const Point<Part>& tip = found.at.tip;
  return formatted(
             "on cuts the %s enters stock that is left, by %.2f mm at most: at %llu %s, on %.1f mm of the "
             "way; the deepest with the tip at (%.3f, %.3f, %.3f); ",
             shank ? "shank" : "holder", found.depth, static_cast<unsigned long long>(found.places),
             found.places == 1 ? "place" : "places", found.length, tip.x, tip.y, tip.z) +
         advice(plan, shank);
}

}  // namespace

Result<void> find_stock_contacts(const Operations& before, const Operations& operations, StageClock& clock,
                                 const PlanListener& told) {
  std::vector<const OperationPlan*> all;
  for (const Operations* some : {&before, &operations})
    for (const auto& one : *some) all.push_back(one.get());
  if (std::none_of(operations.begin(), operations.end(), [](const auto& one) { return may_meet(*one); }))
    return {};
  const auto stock = stock_of(*all.front(), all);
  if (!stock) return {};
  while (!may_meet(*all.back())) all.pop_back();
  std::vector<pathgen::ToolMoves> moves;
  for (const OperationPlan* one : all) moves.push_back(moves_of(*one));
  return clock.time("stock", [&]() -> Result<void> {
    pathgen::StockLeft left(stock->mesh(), moves);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto found = left.cut(moves[i], [&](double share) {
        return told.show("stock", (static_cast<double>(i) + share) / static_cast<double>(all.size()));
      });
      if (!found) return fail(Code::kCancelled, "cancelled; nothing was written");
      if (i < before.size()) continue;
      OperationPlan& one = *operations[i - before.size()];
      one.found_stock(*found);
      for (const bool shank : {true, false})
        if (const pathgen::StockContact& contact = shank ? found->shank : found->holder; contact.places > 0)
          one.warn(warning(one.job().plan, contact, shank));
    }
    return {};
  });
}

std::string stock_text(const OperationPlan& one) {
  const auto& found = one.stock_on_cuts();
  if (!found || !may_meet(one) || found->shank.places + found->holder.places > 0) return "";
  const bool holder = !one.job().plan.cutter.holder.empty(), shank = has_shank(one.job().plan.cutter);
  return formatted("on cuts %s stock that is left nowhere deeper than %.2f mm, on lines %.2f mm apart\n",
                   shank && holder ? "shank and holder enter"
                   : shank         ? "the shank enters"
                                   : "the holder enters",
                   found->touch, found->apart);
}

}  // namespace tiltfeed::daemon
