#pragma once
/// Identifies the program that made a result: written into results.json and run.log, printed by `mpm --version`.

#include <string_view>

namespace mpm {

/// Version, commit and compiler of the library.
struct BuildInfo {
  std::string_view version;          ///< of the library, e.g. "0.1.0"
  std::string_view commit;           ///< short git commit, with "-dirty" if files differed from it; "unknown" outside a repository
  std::string_view compiler;         ///< name and version
  std::string_view build_type;       ///< CMake's build type
  std::string_view instruction_set;  ///< widest vector instructions the library was compiled for
  int simd_width_bits;               ///< width of one vector register; a Lanes value takes 512 / simd_width_bits of them
};

/// The library's own build; costs nothing, never throws.
[[nodiscard]] BuildInfo build_info();

}  // namespace mpm
