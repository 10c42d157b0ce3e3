# How tests are built and registered with CTest.
include(GoogleTest)

option(RELIEF_TEST_SUITES "Register suites with CTest in place of single tests, as the sanitizers always do" OFF)

# Tests that the sanitizers leave to the other presets, as for --gtest_filter. They measure accuracy, limit memory (a
# sanitizer takes as much again for itself), or run code that other tests run as well, many times over or on more data.
set(RELIEF_UNSANITIZED_TESTS
  Accuracy.*
  AlignMesh.UndoesAnyMotion
  AlignViews.AKnownViewThatOverlapsNo*
  AlignViews.AssociatesNearest*
  AlignViews.ClosesARingOf24*
  AlignViews.ClosesARingOfNoisy*
  AlignViews.DoesNotDependOnTheOrder*
  AlignViews.DoesNotDependOnTheUnit
  AlignViews.FindsPosesOfATurntable*
  AlignViews.KeepsAViewInWhichSomethingMoved
  AlignViews.KeepsKnownPosesToTheBit
  AlignViews.LeavesOutAViewOfAnotherUnit*
  AlignViews.MovesWithTheWorld
  AlignViews.NeverSplitsANetwork*
  AlignViews.TakesOutAViewWhosePose*
  AlignViews.TellsOfGivenPosesThatTurn*
  AnalyticShapes.*
  BiasRoughness.NormalsThatErr*
  BuiltInObject.KeepsTheBounds*
  BuiltInObject.NormalsAreContinuous
  CalibrateViews.AppliesWhatItFound
  CalibrateViews.BringsBackViews*
  CalibrateViews.DoesNotTakeErrors*
  CalibrateViews.FindsABendOfEveryView
  CalibrateViews.FindsABendThatAllViewsShare
  CalibrateViews.FindsAnOffset*
  CalibrateViews.FindsNothing*
  CalibrateViews.HeedsTheScope
  CalibrateViews.IsTheSame*
  CalibrateViews.LeavesKnownPoses*
  CalibrateViews.ReturnsToExact*
  CalibrateViews.SaysWhat*
  CalibrateViews.StopsOnRequest
  CalibrateViews.WidensTheDeviations*
  ClosedField.IsSolvedToItsTolerance*
  Closing.ADarkPatchFollows*
  Closing.AHoleOfATenth*
  Closing.ASphereSeenByOneView*
  Closing.ASphereSeenFromOneSide*
  CloudGrid.RealScansAsText*
  DegenerateGroups.KeepTheirMean*
  DegenerateViews.AreVerified*
  DepthCamera.AViewWithoutAPose*
  DepthCamera.GuessesThatAreAllTheSame*
  DepthCamera.ViewsFromOnePlace*
  DepthCamera.ViewsOfARoom*
  DepthCamera.WhatStandsStill*
  DistinctViews.CalibrationIsThat*
  ErrorSpectrum.OfAWave*
  Evaluate.FitsTheResult*
  FairFill.LargeRegionsComeToRest*
  FairFill.OnlyRegionsThatAreSolved*
  FairFill.TheRestOfTheSurface*
  FairFill.TooLargeRegions*
  GlobalRegistration.DoesNotForceASphere*
  GlobalRegistration.FindsShuffledViews*
  GlobalRegistration.FindsViewsAnew*
  GlobalRegistration.KeepsTwoObjects*
  GlobalRegistration.LeavesOutAView*
  GlobalRegistration.PlacesTheBunny*
  HandEye.OfARobot*
  HandEye.OfOneScaleIsTaken
  HtmlReport.HoldsASmallModel*
  HtmlReport.IsNotWritten*
  HtmlReport.ThinsALargeModel
  Icp.NeverReturnsAReflection
  Icp.ReportsTheCovariance*
  InterViewErrors.DoNotDependOnTheOrder*
  InterViewErrors.DoNotGrow*
  JointSolver.ManyPairsNeed*
  KeptLevels.AreAllButTheFinest*
  KeptLevels.AreComputedAgain*
  KeptLevels.OutliveAnInterruption
  KeptResults.AreNamedWhen*
  KeptResults.AreNotTakenByAFreshRun
  KeptResults.BelongToOneRun*
  KeptResults.OfAKilledRun*
  KeptResults.OfAllOtherViews*
  KeptResults.OutliveADiskWithoutRoom
  KeptResults.OutliveKilledRuns
  KeptResults.StayWithin*
  KeptUnits.AreOneForEachPieceOfWork
  KeptUnits.MayBeMissing*
  KeptUnits.OfFinishedViews*
  KeptUnits.OfOther*
  KeptUnits.OfPairs*
  KeptUnits.OfRefining*
  LoopClosure.OfNoisyViews*
  LoopClosure.TellsOfAView*
  MemoryLimitTest.ManyShortLists*
  MergeViews.ASphereConverges*
  MergeViews.AThinPlateKeeps*
  MergeViews.AveragingManyViews*
  MergeViews.FarViewsDoNotSpoil*
  MergeViews.OneViewIsClosedBehind*
  MergeViews.ViewsThatDiffer*
  Multigrid.NeedsFewSteps*
  Multigrid.TheDefaultTolerance*
  Noise.IsFoundOverTheWholeRange*
  Noise.RangesThatErrAlike*
  NormalMaps.DoNoHarm*
  NormalMaps.HoldAPlate*
  NormalMaps/DegenerateViews.*/With*
  PlanarShapes.ABowlIsNotForced
  PlanarShapes.NeighbouringSides*
  PlanarShapes.SidesOfACube*
  PlanarShapes.UnrelatedObjects*
  Ply.ColumnsOfLargeMeshes*
  PoseGraphRefinement.ConvergesAlike*
  PoseGraphRefinement.ReportsTheCovariance*
  PoseGraphSystem.SeesErrorsThatReach*
  Program.ComparesViews*
  Program.DoesNotLoseAccuracy*
  Program.MergesWithinAMemoryLimit*
  Program.RecordsTheHashes*
  Program.RunsTheWholeWay*
  Program.RunsWithinAMemoryLimit*
  Program.RunsWithinTheLimit*
  Program.SingleSteps*
  RangeDeviation.ErrorsAreAsLarge*
  RealNoise.*
  RealScans.AllViewsOfTheDragon*
  RealScans.FiveViewsOfARoom*
  RealScans.TheBunny*
  RealScans.TheDragon*
  RealScans.TwentyViews*
  Reconstruct.GivesOneClosedModel*
  Reconstruct.TellsOfTheStagesInOrder
  ReconstructPart.ComputesWhatIsMissing*
  ReconstructPart.EachComputesItsOwnStageAlone
  ReconstructPart.IntegratesTheField*
  ReconstructPart.NamesTheStep*
  ReconstructPart.RefinesTheViews*
  ReconstructPart.SearchesPairsInBlocks*
  RefineRealScans.TheGeometryOfThePanel*
  RefineView.RefinedViewsAreCloser*
  RefineView.TheLatentBias*
  Render.OptionsChangeThePicture
  Robustness.AHighlight*
  Robustness.RealisticSensors*
  RunOfTwoViews.LinesTell*
  RunOfTwoViews.QuietMeans*
  RunOfTwoViews.TheBarEnds*
  ScanDefects.SensorsErrOnThePlateToo
  SensorErrorCovariance.ExplainsPosesThatAShared*
  SensorErrorCovariance.IsZero*
  SensorErrorCovariance.NamesDistances*
  SensorErrors.*
  SimulatedErrors.*
  StaticBackground.ViewsLoadedOneAtATime*
  Steps.*
  ThinPlate.ALargePlane*
  VertexAttributes.DoNotDependOnTheOrder*
  VertexColours.OfSeveralViews*)

# Suites that take more than about half a minute under some preset. They start first: a long one that starts last works alone
# while the other cores rest.
set(RELIEF_LONG_SUITES
  AlignViews
  BadInput
  CalibrateViews
  Closing
  CloudGrid
  Compare
  DepthCamera
  GlobalRegistration
  HtmlReport
  KeptLevels
  KeptResults
  KeptUnits
  LoopClosure
  MergeViews
  PoseGraphRefinement
  Program
  RealScans
  Reconstruct
  RunOfTwoViews
  Steps)

# The suites of tests in source files.
function(relief_suites_of files result)
  set(suites "")
  foreach(file IN LISTS files)
    file(STRINGS ${file} heads REGEX "^TEST(_F|_P)?\\(")
    foreach(head IN LISTS heads)
      string(REGEX REPLACE "^TEST(_F|_P)?\\( *([A-Za-z0-9_]+).*" "\\2" suite "${head}")
      list(APPEND suites ${suite})
    endforeach()
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  endforeach()
  list(REMOVE_DUPLICATES suites)
  set(${result} ${suites} PARENT_SCOPE)
endfunction()

# One CTest test per suite: a program starts once for all its tests, and what they share is made once. The sanitizers leave
# out the tests that compare numbers of threads, which run the same code twice; they are for the thread sanitizer.
function(relief_add_suites name files)
  relief_suites_of("${files}" suites)
  set(left_out "")
  if(RELIEF_SANITIZE)
    list(JOIN RELIEF_UNSANITIZED_TESTS ":" left_out)
    set(left_out "-*.*Thread*:${left_out}")
  endif()
  foreach(suite IN LISTS suites)
    if(RELIEF_SANITIZE AND "${suite}.*" IN_LIST RELIEF_UNSANITIZED_TESTS)
      continue()
    endif()
    add_test(NAME ${name}.${suite}
      COMMAND relief_${name}_tests "--gtest_filter=${suite}.*:*/${suite}.*${left_out}")
    set_tests_properties(${name}.${suite} PROPERTIES TIMEOUT 1800)
    if(suite IN_LIST RELIEF_LONG_SUITES)
      set_tests_properties(${name}.${suite} PROPERTIES COST 100)
    endif()
  endforeach()
endfunction()

# The thread sanitizer watches the tests that compare numbers of threads: of the source files with tests, those that have
# such ones. Tests that read files are left out, and with them the libraries for that.
function(relief_thread_tests_of files result)
  set(kept "")
  foreach(file IN LISTS files)
    file(READ ${file} text)
    if(NOT text MATCHES "\nTEST" OR (text MATCHES "\nTEST(_F|_P)?\\([A-Za-z]+, [A-Za-z0-9]*Thread" AND NOT text MATCHES "relief/io|scan/io"))
      list(APPEND kept ${file})
    endif()
  endforeach()
  set(${result} ${kept} PARENT_SCOPE)
endfunction()

# Two CTest tests, each for half of the tests that compare numbers of threads. VTK's own loops run on one thread there: they run
# on TBB otherwise, which the sanitizer cannot see into.
function(relief_add_thread_tests name)
  list(JOIN RELIEF_UNSANITIZED_TESTS ":" left_out)
  foreach(half 0 1)
    add_test(NAME ${name}.threads.${half}
      COMMAND relief_${name}_tests "--gtest_filter=*Thread*:ParallelFor.*:RunIn.*-${left_out}")
    set_tests_properties(${name}.threads.${half} PROPERTIES TIMEOUT 1800
      ENVIRONMENT "VTK_SMP_BACKEND_IN_USE=Sequential;GTEST_TOTAL_SHARDS=2;GTEST_SHARD_INDEX=${half}")
    if(name MATCHES "^(registration|reconstruction)$")  # Longest: see RELIEF_LONG_SUITES.
      set_tests_properties(${name}.threads.${half} PROPERTIES COST 100)
    endif()
  endforeach()
endfunction()

function(relief_register_tests name files)
  if(RELIEF_SANITIZE MATCHES "thread")
    relief_add_thread_tests(${name})
  elseif(RELIEF_SANITIZE OR RELIEF_TEST_SUITES)
    relief_add_suites(${name} "${files}")
  else()
    # Parameters have names: CTest need not know what their values look like.
    gtest_discover_tests(relief_${name}_tests NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60
                         PROPERTIES TIMEOUT 600)
  endif()
endfunction()

# The project's static libraries that a target is linked with, each once.
function(relief_libraries_of target found)
  get_target_property(linked ${target} LINK_LIBRARIES)
  set(all ${${found}})
  foreach(library IN LISTS linked)
    string(REGEX REPLACE "^relief::" "relief_" library ${library})
    if(library MATCHES "^relief_" AND NOT library IN_LIST all)
      get_target_property(type ${library} TYPE)
      if(type STREQUAL "STATIC_LIBRARY")
        list(APPEND all ${library})
        relief_libraries_of(${library} all)
      endif()
    endif()
  endforeach()
  set(${found} ${all} PARENT_SCOPE)
endfunction()

# Of a function in a header, compiled for the tests and for a library, the linker takes the first: that of the library, which the
# sanitizer watches.
function(relief_prefer_libraries target)
  set(libraries "")
  relief_libraries_of(${target} libraries)
  list(FILTER libraries EXCLUDE REGEX "test_support")
  list(TRANSFORM libraries REPLACE "(.+)" "$<TARGET_FILE:\\1>" OUTPUT_VARIABLE files)
  target_link_options(${target} PRIVATE LINKER:--whole-archive ${files} LINKER:--no-whole-archive)
endfunction()

# relief_test(NAME LIBRARIES ... SOURCES ...): one test program per folder, registered with CTest.
function(relief_test name)
  cmake_parse_arguments(ARG "" "" "LIBRARIES;SOURCES" ${ARGN})
  if(RELIEF_SANITIZE MATCHES "thread")
    relief_thread_tests_of("${ARG_SOURCES}" ARG_SOURCES)
    if(NOT ARG_SOURCES MATCHES "_test")
      return()
    endif()
  endif()
  add_executable(relief_${name}_tests ${ARG_SOURCES})
  target_link_libraries(relief_${name}_tests PRIVATE ${ARG_LIBRARIES} relief_test_support relief_test_flags
                                                     GTest::gmock GTest::gtest_main)
  if(RELIEF_SANITIZE MATCHES "address")
    relief_prefer_libraries(relief_${name}_tests)
  elseif(RELIEF_SANITIZE)
    # Tests spend their time in the libraries; their own code compiles in two thirds of the time like this.
    target_compile_options(relief_${name}_tests PRIVATE -Og)
  endif()
  if(NOT name STREQUAL "interop")  # Those are compiled with the options of PCL and VTK.
    relief_share_precompiled(relief_${name}_tests relief_test_support)
  endif()
  relief_register_tests(${name} "${ARG_SOURCES}")
  relief_group_sources(relief_${name}_tests)
endfunction()
