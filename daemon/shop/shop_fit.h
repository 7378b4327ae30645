#pragma once
// What a job of the shop needs, what a machine has, and the one rule that compares them.

#include <optional>
#include <string>
#include <vector>

#include "config/machine_profile.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Longest text of needs or of what a machine has, bytes.
inline constexpr std::size_t kMostShopJson = 8192;
/// More tools and axes than any of them names.
inline constexpr std::size_t kMostShopTools = 200, kMostShopAxes = 5;

struct ShopTravel {
  char letter = 'X';
  double min = 0.0, max = 0.0;  ///< mm, degrees
  bool operator==(const ShopTravel&) const = default;
};

struct ShopTool {
  int number = 0;  ///< the program's T; 0: not said
  std::string id;  ///< of a tool library; empty: not said
  bool operator==(const ShopTool&) const = default;
};

/// Of a job. What is empty is not asked for.
struct ShopNeeds {
  std::string profile;  ///< name of the machine profile
  std::string values;   ///< digest of its values, as profile_values has it
  std::string dialect;
  std::vector<ShopTravel> travels;  ///< where its axes go
  std::vector<ShopTool> tools;
  bool operator==(const ShopNeeds&) const = default;
};

/// Of a machine.
struct ShopOffer {
  std::string profile, values, dialect;
  std::vector<ShopTravel> travels;  ///< of the axes that it has
  std::vector<ShopTool> tools;      ///< of its magazine; empty: not known
  bool operator==(const ShopOffer&) const = default;
};

/// SHA-256 of the profile's values, 64 hexadecimal digits: remarks, order and the file's name do not count.
std::string profile_values(const config::MachineProfile& profile);
ShopOffer offer_of(const config::MachineProfile& profile);

/// Why the machine cannot have the job; nothing: it can. Properties: 1 A profile, its values and a dialect
/// that are asked for are equal. 2 Each axis that the job moves is there, and goes at least as far both ways.
/// 3 Each tool is in the magazine: by its id where both say one, else by its number. A machine without a
/// known magazine takes any tool: its operator mounts it. 4 Whatever is not asked for fits.
std::optional<std::string> misfit(const ShopNeeds& needs, const ShopOffer& offer);

std::string needs_json(const ShopNeeds& needs);
std::string offer_json(const ShopOffer& offer);
/// Of a text that anybody may have written. Errors: kInput: no such object, too long, too many, an unknown
/// key (a need that is not understood is not met).
Result<ShopNeeds> parse_needs(const std::string& json);
Result<ShopOffer> parse_offer(const std::string& json);
/// For people: "profile generic-ac; X -10 to 20; tool 3".
std::string needs_text(const ShopNeeds& needs);

}  // namespace tiltfeed::daemon
