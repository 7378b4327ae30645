#include "daemon/shop/shop_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/files/sha256.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

/// JSON has no infinity: an endless axis goes so far.
constexpr double kEndless = 1e9;
/// Printed words are rounded: so much beyond a travel is none, mm or degrees.
constexpr double kRounding = 1e-6;
constexpr int kShownDecimals = 3;

std::string range_text(const ShopTravel& travel) {
  return decimal(travel.min, kShownDecimals) + " to " + decimal(travel.max, kShownDecimals);
}

std::string tool_name_text(const ShopTool& tool) {
  if (tool.id.empty()) return "T" + std::to_string(tool.number);
  return tool.number > 0 ? tool.id + " (T" + std::to_string(tool.number) + ")" : tool.id;
}

bool same_tool(const ShopTool& wanted, const ShopTool& there) {
  if (!wanted.id.empty() && !there.id.empty()) return wanted.id == there.id;
  return wanted.number > 0 && wanted.number == there.number;
}

double bounded(double value) { return std::clamp(value, -kEndless, kEndless); }

template <class Travels>
ordered_json travels_of(const Travels& travels) {
  ordered_json object = ordered_json::object();
  for (const ShopTravel& one : travels) object[std::string(1, one.letter)] = {one.min, one.max};
  return object;
}

ordered_json tools_of(const std::vector<ShopTool>& tools) {
  ordered_json list = ordered_json::array();
  for (const ShopTool& one : tools) {
    ordered_json tool = ordered_json::object();
    if (one.number > 0) tool["number"] = one.number;
    if (!one.id.empty()) tool["id"] = one.id;
    list.push_back(std::move(tool));
  }
  return list;
}

/// A text that JSON can hold, whatever bytes are in it.
std::string dumped(const ordered_json& json) {
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

/// What both have.
struct ShopSide {
  std::string profile, values, dialect;
  std::vector<ShopTravel> travels;
  std::vector<ShopTool> tools;
};

std::string side_json(const ShopSide& side) {
  ordered_json json = ordered_json::object();
  if (!side.profile.empty()) json["profile"] = side.profile;
  if (!side.values.empty()) json["values"] = side.values;
  if (!side.dialect.empty()) json["dialect"] = side.dialect;
  if (!side.travels.empty()) json["travels"] = travels_of(side.travels);
  if (!side.tools.empty()) json["tools"] = tools_of(side.tools);
  return dumped(json);
}

tl::unexpected<Error> not_understood(const std::string& what) {
  return fail(Code::kInput, "what it needs is not understood: " + what);
}

Result<ShopTravel> parse_travel(const std::string& key, const ordered_json& value) {
  const bool letter = key.size() == 1 && key[0] >= 'A' && key[0] <= 'Z';
  if (!letter || !value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number())
    return not_understood("a travel is \"X\": [min, max]");
  const ShopTravel travel{key[0], value[0].get<double>(), value[1].get<double>()};
  if (!std::isfinite(travel.min) || !std::isfinite(travel.max) || travel.min > travel.max)
    return not_understood("the travel of " + key + " has no range");
  return travel;
}

Result<ShopTool> parse_shop_tool(const ordered_json& value) {
  if (!value.is_object()) return not_understood("a tool is an object");
  ShopTool tool;
  for (const auto& [key, word] : value.items()) {
    constexpr std::size_t kLongestId = 80;
    if (key == "number" && word.is_number_integer() && word >= 1 && word <= 1000000)
      tool.number = word.get<int>();
    else if (key == "id" && word.is_string() && word.get_ref<const std::string&>().size() <= kLongestId)
      tool.id = word.get<std::string>();
    else
      return not_understood("a tool has a number and an id");
  }
  if (tool.number == 0 && tool.id.empty()) return not_understood("a tool has neither number nor id");
  return tool;
}

Result<void> parse_list(const std::string& key, const ordered_json& value, ShopSide& side) {
  if (key == "travels" && value.is_object() && value.size() <= kMostShopAxes) {
    for (const auto& [letter, range] : value.items()) {
      const Result<ShopTravel> travel = parse_travel(letter, range);
      if (!travel) return tl::unexpected<Error>(travel.error());
      side.travels.push_back(*travel);
    }
    return {};
  }
  if (key != "tools" || !value.is_array() || value.size() > kMostShopTools)
    return not_understood("a key that this version does not know, or too much of it");
  for (const ordered_json& one : value) {
    Result<ShopTool> tool = parse_shop_tool(one);
    if (!tool) return tl::unexpected<Error>(tool.error());
    side.tools.push_back(std::move(*tool));
  }
  return {};
}

Result<ShopSide> parse_side(const std::string& text) {
  if (text.size() > kMostShopJson) return not_understood("it is too long");
  // Nothing of it is deeper than this; a deeper text is cut off, and then no such object.
  constexpr int kDeepest = 4;
  const auto shallow = [](int depth, ordered_json::parse_event_t, ordered_json&) {
    return depth <= kDeepest;
  };
  const ordered_json json = ordered_json::parse(text, shallow, false);
  if (!json.is_object()) return not_understood("it is no JSON object");
  ShopSide side;
  for (const auto& [key, value] : json.items()) {
    std::string* const word = key == "profile"   ? &side.profile
                              : key == "values"  ? &side.values
                              : key == "dialect" ? &side.dialect
                                                 : nullptr;
    if (word == nullptr) {
      if (const Result<void> list = parse_list(key, value, side); !list)
        return tl::unexpected<Error>(list.error());
    } else if (value.is_string()) {
      *word = value.get<std::string>();
    } else {
      return not_understood(key + " is no text");
    }
  }
  return side;
}

std::optional<std::string> lacks_travel(const ShopTravel& need, const ShopOffer& offer) {
  const std::string letter(1, need.letter);
  for (const ShopTravel& has : offer.travels) {
    if (has.letter != need.letter) continue;
    if (need.min >= has.min - kRounding && need.max <= has.max + kRounding) return std::nullopt;
    return letter + " goes " + range_text(has) + ", the job " + range_text(need);
  }
  return "it has no axis " + letter;
}

}  // namespace

std::string profile_values(const config::MachineProfile& profile) {
  config::MachineProfile values = profile;
  values.path.clear();
  // The wire and the magazine are of one machine of the kind: a program fits all of them.
  values.link.clear();
  values.wire = {};
  values.receive_buffer = 0;
  values.link_rate = 0.0;
  values.magazine.clear();
  return hex(sha256(config::describe(values)));
}

ShopOffer offer_of(const config::MachineProfile& profile) {
  ShopOffer offer{
      profile.model.name, profile_values(profile), config::name_of(profile.format.dialect).name, {}, {}};
  const std::pair<char, const LinearAxis*> linear[] = {
      {'X', &profile.model.x}, {'Y', &profile.model.y}, {'Z', &profile.model.z}};
  for (const auto& [letter, axis] : linear)
    offer.travels.push_back({letter, bounded(axis->min), bounded(axis->max)});
  for (const RotaryAxis* axis : {&profile.model.tilt, &profile.model.rotary})
    if (axis->present) offer.travels.push_back({axis->letter, bounded(axis->min), bounded(axis->max)});
  for (const config::MagazineTool& tool : profile.magazine)
    if (offer.tools.size() < kMostShopTools) offer.tools.push_back({tool.number, tool.id});
  return offer;
}

std::optional<std::string> misfit(const ShopNeeds& needs, const ShopOffer& offer) {
  if (!needs.profile.empty() && needs.profile != offer.profile)
    return "it is for the profile " + needs.profile + ", this is " + offer.profile;
  if (!needs.values.empty() && needs.values != offer.values)
    return "it is for other values of the profile " + offer.profile + " (travels, pivots, signs ...)";
  if (!needs.dialect.empty() && needs.dialect != offer.dialect)
    return "it is in the dialect " + needs.dialect + ", the control reads " + offer.dialect;
  for (const ShopTravel& travel : needs.travels)
    if (auto why = lacks_travel(travel, offer)) return why;
  if (offer.tools.empty()) return std::nullopt;
  for (const ShopTool& wanted : needs.tools)
    if (std::none_of(offer.tools.begin(), offer.tools.end(),
                     [&](const ShopTool& there) { return same_tool(wanted, there); }))
      return "its magazine has no " + tool_name_text(wanted);
  return std::nullopt;
}

std::string needs_json(const ShopNeeds& needs) {
  return side_json({needs.profile, needs.values, needs.dialect, needs.travels, needs.tools});
}

std::string offer_json(const ShopOffer& offer) {
  return side_json({offer.profile, offer.values, offer.dialect, offer.travels, offer.tools});
}

Result<ShopNeeds> parse_needs(const std::string& json) {
  Result<ShopSide> side = parse_side(json);
  if (!side) return tl::unexpected<Error>(side.error());
  return ShopNeeds{side->profile, side->values, side->dialect, side->travels, side->tools};
}

Result<ShopOffer> parse_offer(const std::string& json) {
  Result<ShopSide> side = parse_side(json);
  if (!side) return tl::unexpected<Error>(side.error());
  return ShopOffer{side->profile, side->values, side->dialect, side->travels, side->tools};
}

std::string needs_text(const ShopNeeds& needs) {
  std::vector<std::string> parts;
  if (!needs.profile.empty())
    parts.push_back("profile " + needs.profile + (needs.values.empty() ? "" : " with these values"));
  if (!needs.dialect.empty()) parts.push_back("dialect " + needs.dialect);
  for (const ShopTravel& travel : needs.travels)
    parts.push_back(std::string(1, travel.letter) + " " + range_text(travel));
  for (const ShopTool& tool : needs.tools) parts.push_back("tool " + tool_name_text(tool));
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : "; ") + part;
  return text.empty() ? "any machine" : text;
}

}  // namespace tiltfeed::daemon
