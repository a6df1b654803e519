# Installs the build into a folder of its own, builds examples/consumer against it and runs it: finds headers, libraries
# and package files that the installation forgets. Run by ctest with -DSOURCE=... -DBUILD=... -DFLAGS=...
set(work ${BUILD}/consumer)
file(REMOVE_RECURSE ${work})
function(run)
  execute_process(COMMAND ${ARGV} WORKING_DIRECTORY ${SOURCE} OUTPUT_VARIABLE out ERROR_VARIABLE out RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGV}\n${out}")
  endif()
  set(out "${out}" PARENT_SCOPE)
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${work}/prefix)
run(${CMAKE_COMMAND} -G Ninja -S examples/consumer -B ${work}/build -DCMAKE_PREFIX_PATH=${work}/prefix
    -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS=${FLAGS}")
run(${CMAKE_COMMAND} --build ${work}/build)
run(${work}/build/press)
message("${out}")
if(NOT out MATCHES "0\\.5 s: normal 0\\.[0-9]*[1-9][0-9]* N, friction 0\\.[0-9]*[1-9][0-9]* N")
  message(FATAL_ERROR "the consumer printed no force")
endif()

# The README shows this program: the one that was just compiled.
file(READ ${SOURCE}/examples/consumer/press.cpp program)
file(READ ${SOURCE}/README.md readme)
string(FIND "${readme}" "${program}" found)
if(found EQUAL -1)
  message(FATAL_ERROR "README.md does not hold examples/consumer/press.cpp as it is")
endif()
