#include "libmpm/io/joint_file.hpp"

#include <fmt/format.h>

#include <new>
#include <utility>

#include "libmpm/base/process.hpp"

namespace mpm {

namespace {

void put_layout(Message& message, const hdf5::Layout& layout) {
  put_text(message, layout.target.string());
  put_text(message, layout.temporary.string());
  put(message, static_cast<std::uint64_t>(layout.arrays.size()));
  for (const auto& array : layout.arrays) {
    put_text(message, array.name);
    put(message, array.offset);
    put(message, array.bytes);
  }
}
hdf5::Layout get_layout(MessageReader& reader) {
  hdf5::Layout layout;
  layout.target = reader.get_text();
  layout.temporary = reader.get_text();
  layout.arrays.resize(reader.get<std::uint64_t>());
  for (auto& array : layout.arrays) {
    array.name = reader.get_text();
    array.offset = reader.get<std::uint64_t>();
    array.bytes = reader.get<std::uint64_t>();
  }
  return layout;
}

/// "rank 2 on node17: cannot write ..."
std::string with_place(int rank, const std::string& what) { return fmt::format("rank {} on {}: {}", rank, host_name(), what); }

/// Exit code and text of an error; nothing where there is none.
Message report_of(const FirstError& error, int rank) {
  Message message;
  const auto report = [&](ExitCode code, const std::string& what) {
    put(message, code);
    put_text(message, with_place(rank, what));
  };
  try {
    error.rethrow();
  } catch (const Error& e) {
    report(e.code(), e.what());
  } catch (const std::bad_alloc&) {
    report(ExitCode::internal, "out of memory");
  } catch (const std::exception& e) {
    report(ExitCode::internal, e.what());
  }
  return message;
}

[[noreturn]] void rethrow(const Message& report) {
  MessageReader reader(report);
  const auto code = reader.get<ExitCode>();
  const std::string what = reader.get_text();
  if (code == ExitCode::io) throw IoError(what);
  throw Error(code, what);
}

}  // namespace

bool agree_on_errors(const FirstError& own, Ranks& ranks) {
  Message failed;
  const Message* worst = nullptr;
  const auto reports = ranks.gather(report_of(own, ranks.rank()));
  for (const Message& report : reports) {
    if (worst == nullptr && !report.empty()) worst = &report;
  }
  if (worst != nullptr) put(failed, std::byte{1});
  ranks.share(failed);
  if (worst != nullptr) {
    ranks.done();
    own.rethrow();
    rethrow(*worst);
  }
  return failed.empty();
}

void JointFile::begin(const std::function<std::unique_ptr<hdf5::Writer>()>& make, Message& about) {
  hdf5::Layout layout;
  if (ranks_.first()) {
    error_.attempt([&] {
      file_ = make();
      layout = file_->layout();
    });
  }
  Message message;
  put_layout(message, layout);
  put(message, std::span<const std::byte>(about));
  ranks_.share(message);
  MessageReader reader(message);
  layout = get_layout(reader);
  about = reader.values<std::byte>();
  if (layout.temporary.empty()) return;  // the first rank could not begin it
  error_.attempt([&] { values_.emplace(std::move(layout)); });
}

void JointFile::commit(const std::filesystem::path& keep_as) {
  std::vector<hdf5::WrittenBytes> written;
  attempt([&](hdf5::ArrayWriter& values) { written = values.finish(); });
  values_.reset();
  Message mine;
  put(mine, std::span<const hdf5::WrittenBytes>(written));
  const std::vector<Message> all = ranks_.gather(std::move(mine));
  if (file_) {
    error_.attempt([&] {
      for (const Message& message : all) file_->add(MessageReader(message).values<hdf5::WrittenBytes>());
    });
  }
  agree_on_errors(error_, ranks_);
  ranks_.done();
  if (file_) file_->commit(keep_as);
}

}  // namespace mpm
