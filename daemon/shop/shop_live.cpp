#include "daemon/shop/shop_live.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

constexpr std::size_t kLongestJob = 40, kLongestAlarm = 300;

/// $1 now, ms. Of each machine the states of the week, and the one that it had when the week began: each
/// machine's range of the index is read once.
constexpr const char* kUsage = R"sql(
WITH known AS MATERIALIZED (SELECT m.id, (extract(epoch FROM m.seen) * 1000)::bigint AS heard,
    coalesce((SELECT max(b.at) FROM tiltfeed.states b WHERE b.machine = m.id AND b.at <= $1::bigint - 604800000), 0) AS begins
  FROM tiltfeed.machines m)
SELECT known.id, spans.state,
  sum(greatest(0, least(spans.ends, $1::bigint) - greatest(spans.at, $1::bigint - 86400000)))::bigint,
  sum(greatest(0, least(spans.ends, $1::bigint) - greatest(spans.at, $1::bigint - 604800000)))::bigint
FROM known CROSS JOIN LATERAL (SELECT s.at, s.state, lead(s.at, 1, known.heard) OVER (ORDER BY s.at) AS ends
  FROM tiltfeed.states s WHERE s.machine = known.id AND s.at >= known.begins) AS spans
GROUP BY known.id, spans.state ORDER BY known.id, spans.state)sql";
constexpr const char* kNow = "SELECT (extract(epoch FROM now()) * 1000)::bigint";

std::string cut(const std::string& text, std::size_t most) {
  std::size_t end = std::min(text.size(), most);
  while (end < text.size() && end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end);
}

std::string text_at(const ordered_json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::uint64_t count_at(const ordered_json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

}  // namespace

bool is_shop_state(const std::string& word) {
  constexpr const char* kWords[] = {kShopIdle,  kShopRunning, kShopHeld,   kShopSetup,
                                    kShopFault, kShopOff,     kShopUnknown};
  return std::any_of(std::begin(kWords), std::end(kWords), [&](const char* one) { return word == one; });
}

std::string live_json(const ShopLive& live) {
  ordered_json json = {{"state", live.state}, {"clock", live.clock}};
  if (!live.job.empty()) json["job"] = cut(live.job, kLongestJob);
  if (!live.alarm.empty()) json["alarm"] = cut(live.alarm, kLongestAlarm);
  if (live.blocks > 0) json["blocks"] = live.blocks, json["executed"] = live.executed;
  if (live.remaining_seconds >= 0.0) json["remaining_seconds"] = std::round(live.remaining_seconds);
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

ShopLive parse_live(const std::string& text) {
  ShopLive live;
  if (text.size() > kMostLiveJson) return live;
  const ordered_json json = ordered_json::parse(text, nullptr, false);
  if (!json.is_object()) return live;
  if (const std::string state = text_at(json, "state"); is_shop_state(state)) live.state = state;
  live.job = cut(text_at(json, "job"), kLongestJob);
  live.alarm = cut(text_at(json, "alarm"), kLongestAlarm);
  live.blocks = count_at(json, "blocks");
  live.executed = count_at(json, "executed");
  live.clock = count_at(json, "clock");
  const auto left = json.find("remaining_seconds");
  if (left != json.end() && left->is_number() && left->get<double>() >= 0.0 &&
      std::isfinite(left->get<double>()))
    live.remaining_seconds = left->get<double>();
  return live;
}

Result<std::map<std::string, std::vector<ShopUsage>>> view_usage(const ShopAsk& ask) {
  const auto clock = ask(kNow, {});
  if (!clock) return tl::unexpected<Error>(clock.error());
  const auto rows = ask(kUsage, {clock->rows.at(0).at(0)});
  if (!rows) return tl::unexpected<Error>(rows.error());
  std::map<std::string, std::vector<ShopUsage>> usage;
  constexpr double kMs = 1000.0;
  for (const PgRow& row : rows->rows)
    if (row.size() == 4 && is_shop_state(row[1]))
      usage[row[0]].push_back(
          {row[1], std::strtod(row[2].c_str(), nullptr) / kMs, std::strtod(row[3].c_str(), nullptr) / kMs});
  return usage;
}

}  // namespace tiltfeed::daemon
