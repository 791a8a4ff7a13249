#pragma once
/// Python scripts that commands call for pictures and pages.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace mpm::app {

inline constexpr const char* python = "/usr/bin/python3";  ///< Debian's interpreter, which finds Debian's pandas, h5py and matplotlib
/// The Debian packages that the scripts need, for messages.
inline constexpr const char* python_packages = "python3-pandas, python3-matplotlib, python3-h5py, python3-scipy and python3-jinja2";

/// A script of the installation this program belongs to, or of the sources it was built from. @param name  "plot_run.py"
[[nodiscard]] std::optional<std::filesystem::path> find_script(const std::string& name);

/// Runs a script, whose messages go to this program's stdout and stderr. @return its exit status, 127 if it could not be started
[[nodiscard]] int run_script(const std::filesystem::path& script, const std::vector<std::string>& arguments);

}  // namespace mpm::app
