# SPDX-License-Identifier: BSD-3-Clause
# How every folder becomes a target, so that flags and install rules are said once.

add_library(terrace_options INTERFACE)
add_library(terrace::options ALIAS terrace_options)
# No fused multiply-add behind our back: the same input must give the same bits on every processor.
target_compile_options(terrace_options INTERFACE -ffp-contract=off -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Wno-missing-field-initializers
                                                 $<$<BOOL:${TERRACE_WERROR}>:-Werror>
                                                 # Where several files are compiled as one, GCC takes them for headers.
                                                 $<$<AND:$<BOOL:${CMAKE_UNITY_BUILD}>,$<CXX_COMPILER_ID:GNU>>:-Wno-subobject-linkage>
                                                 $<$<BOOL:${TERRACE_NATIVE}>:-march=native>)
if(TERRACE_SANITIZE)
  # GCC takes what the sanitizers insert for reads of unset variables; the presets' -O1 keeps the tests within minutes.
  target_compile_options(terrace_options INTERFACE -fsanitize=${TERRACE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all
                                                   $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(terrace_options INTERFACE -fsanitize=${TERRACE_SANITIZE})
endif()

# terrace_library(NAME SOURCES... [PUBLIC targets...] [PRIVATE targets...])
# One folder, one target: terrace_NAME, used as terrace::NAME. Headers are included from the top: "core/time.h"; where they are
# installed, below terrace/: "terrace/core/time.h".
function(terrace_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(terrace_${name} STATIC ${ARG_SOURCES})
  add_library(terrace::${name} ALIAS terrace_${name})
  set_target_properties(terrace_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(terrace_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(terrace_${name} PUBLIC cxx_std_20)
  target_link_libraries(terrace_${name} PUBLIC ${ARG_PUBLIC} PRIVATE $<BUILD_INTERFACE:terrace::options> ${ARG_PRIVATE})
  if(TERRACE_FUZZ)
    # libFuzzer follows which branches its bytes reach in what reads them; folders that compute read nothing.
    target_compile_options(terrace_${name} PRIVATE $<$<NOT:$<BOOL:$<TARGET_PROPERTY:terrace_computes>>>:-fsanitize=fuzzer-no-link>)
  endif()
endfunction()

# terrace_computes(NAME): a folder in which frames spend their time. Short loops of known length are unrolled, simple ones
# turned into vectors; nobody asks for floating-point traps or for errno after a square root.
function(terrace_computes name)
  set_target_properties(terrace_${name} PROPERTIES terrace_computes ON)
  target_compile_options(terrace_${name} PRIVATE "$<$<CONFIG:Release>:-O3;-fno-trapping-math;-fno-math-errno>")
endfunction()

# terrace_uses_simd(NAME SOURCES...): Highway compiles these files of a folder once for each instruction set that a robot may
# have, chosen at run time; without SSSE3 (nobody has it and not SSE4) and SVE, whose vectors cannot be put into arrays. The
# plain C++ target stays on: the compiler bug for which Highway avoids it concerns operations that are not used here, and the
# tests compare every target.
function(terrace_uses_simd name)
  target_link_libraries(terrace_${name} PRIVATE PkgConfig::HWY)
  target_compile_definitions(terrace_${name} PRIVATE
    HWY_WANT_AVX3_DL=1 HWY_BROKEN_EMU128=0 "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128)")
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# terrace_called_by_tbb(SOURCES...): files that the thread sanitizer must not judge, because TBB, which it cannot see into,
# starts and ends what they do; they tell it of that where TERRACE_SANITIZE_THREAD is defined.
function(terrace_called_by_tbb)
  if(TERRACE_SANITIZE STREQUAL "thread")
    set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "-fno-sanitize=thread;-DTERRACE_SANITIZE_THREAD")
  endif()
endfunction()

# terrace_test(FOLDER SOURCES... [LINK targets...] [TIMEOUT seconds] [LABELS labels...])
# One test program a folder, terrace_FOLDER_test; every TEST in it becomes a ctest test of its own.
function(terrace_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;LINK;LABELS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  add_executable(terrace_${name}_test ${ARG_SOURCES})
  target_link_libraries(terrace_${name}_test PRIVATE terrace::options ${ARG_LINK} GTest::gtest GTest::gmock GTest::gtest_main)
  # What is tested is built as it runs on the robot; the tests' own code need not be, and compiles a quarter faster.
  target_compile_options(terrace_${name}_test PRIVATE $<$<CONFIG:Release>:-O1>)
  # Temporary files lie in the build folder, so that the tests of two checkouts can run side by side.
  gtest_discover_tests(terrace_${name}_test DISCOVERY_TIMEOUT 60
                       PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${name};${ARG_LABELS}" ENVIRONMENT TEST_TMPDIR=${CMAKE_CURRENT_BINARY_DIR})
endfunction()

# terrace_bench(NAME SOURCES... [LINK targets...])
function(terrace_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(terrace_${name}_bench ${ARG_SOURCES})
  target_link_libraries(terrace_${name}_bench PRIVATE terrace::options ${ARG_LINK} benchmark::benchmark benchmark::benchmark_main)
endfunction()
