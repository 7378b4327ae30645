#include "daemon/machine/order_mark.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

std::string mark_path(const std::string& folder) { return folder + "/moving"; }

constexpr LinkKind kKinds[] = {LinkKind::kGrbl,      LinkKind::kRepRap,    LinkKind::kDrip,
                               LinkKind::kModbusTcp, LinkKind::kModbusRtu, LinkKind::kDriveTcp,
                               LinkKind::kDriveRtu};

}  // namespace

Result<void> mark_order(const std::string& folder, LinkKind link, const std::string& text) {
  std::ofstream out(mark_path(folder), std::ios::trunc);
  out << static_cast<int>(link) << ' ' << text << "\n" << std::flush;
  if (!out) return fail(Code::kIo, mark_path(folder) + ": cannot be written: " + std::strerror(errno));
  return {};
}

void clear_order_mark(const std::string& folder) {
  std::error_code none;
  std::filesystem::remove(mark_path(folder), none);
}

std::optional<MarkedOrder> marked_order(const std::string& folder) {
  std::error_code failed;
  const bool there = std::filesystem::exists(mark_path(folder), failed);
  if (!there && !failed) return std::nullopt;
  std::ifstream in(mark_path(folder));
  int kind = -1;
  std::string text;
  if (!(in >> kind) || !std::getline(in >> std::ws, text))
    return MarkedOrder{std::nullopt, mark_path(folder) + " cannot be read"};
  for (const LinkKind one : kKinds)
    if (static_cast<int>(one) == kind) return MarkedOrder{one, wire_text(text)};
  return MarkedOrder{std::nullopt, mark_path(folder) + " names no link"};
}

}  // namespace tiltfeed::daemon
