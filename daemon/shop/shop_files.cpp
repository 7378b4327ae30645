// The files of a claimed job, piece by piece out of the database.

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "daemon/files/sha256.h"
#include "daemon/shop/shop_client.h"
#include "daemon/shop/shop_layout.h"

namespace tiltfeed::daemon {

namespace {

int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/// False: no such text.
bool from_hex(const std::string& text, std::string& bytes) {
  if (text.size() % 2 != 0) return false;
  bytes.resize(text.size() / 2);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const int high = digit_of(text[2 * i]), low = digit_of(text[2 * i + 1]);
    if (high < 0 || low < 0) return false;
    bytes[i] = static_cast<char>(high * 16 + low);
  }
  return true;
}

Result<void> write_all(int file, const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t written = ::write(file, bytes.data() + done, bytes.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0)
      return fail(Code::kIo, std::string("the spool takes no file of the shop: ") + std::strerror(errno));
    done += static_cast<std::size_t>(written);
  }
  return {};
}

Result<void> fetch_file(const ShopAsk& ask, const ShopJob& job, std::size_t index, int into) {
  const ShopFile& wanted = job.files[index];
  Sha256Sum sum;
  std::string bytes;
  std::uint64_t have = 0;
  for (std::uint64_t piece = 0; have < wanted.bytes; ++piece) {
    const Result<PgRows> rows = ask(kShopPiece, {job.ticket.job, std::uint64_t{index}, piece});
    if (!rows) return tl::unexpected<Error>(rows.error());
    const bool one =
        rows->rows.size() == 1 && rows->rows[0].size() == 1 && rows->rows[0][0].size() <= 2 * kShopPieceBytes;
    if (!one || !from_hex(rows->rows[0][0], bytes) || bytes.empty() || have + bytes.size() > wanted.bytes)
      return fail(Code::kInput, "its file in the database is not whole; submit it again");
    sum.add(bytes);
    have += bytes.size();
    if (const Result<void> written = write_all(into, bytes); !written) return written;
  }
  if (hex(sum.finish()) != wanted.sha256)
    return fail(Code::kInput,
                "its file in the database is not the one that was submitted (SHA-256); submit it again");
  if (::lseek(into, 0, SEEK_SET) != 0)
    return fail(Code::kIo, std::string("the spool's file of the shop: ") + std::strerror(errno));
  return {};
}

}  // namespace

Result<std::vector<int>> fetch_files(const ShopAsk& ask, const ShopJob& job,
                                     const std::function<int()>& scratch) {
  std::vector<int> files;
  for (std::size_t index = 0; index < job.files.size(); ++index) {
    files.push_back(scratch());
    Result<void> fetched;
    if (files.back() < 0)
      fetched = fail(Code::kIo, std::string("the spool takes no file of the shop: ") + std::strerror(errno));
    else
      fetched = fetch_file(ask, job, index, files.back());
    if (fetched) continue;
    for (const int file : files)
      if (file >= 0) ::close(file);
    return tl::unexpected<Error>(fetched.error());
  }
  return files;
}

}  // namespace tiltfeed::daemon
