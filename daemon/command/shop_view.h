#pragma once
// The shop's queue and its machines, as JSON and for people.

#include <map>
#include <string>
#include <vector>

#include "daemon/shop/shop_orders.h"

namespace tiltfeed::daemon {

void add_usage(const std::map<std::string, std::vector<ShopUsage>>& usage, ShopView& view);
/// One object, as `tiltfeed shop list --json` prints it.
std::string view_json(const ShopView& view);
std::string view_text(const ShopView& view);
std::string machine_line(const ShopMachine& one);

}  // namespace tiltfeed::daemon
