# Tests that take some 8 s of a processor's time each, or more: their label ends in `_long`. scripts/test leaves them out,
# scripts/test --all and the nightly job run them. Each has quicker tests of the same thing beside it
# (docs/architecture.md#build-and-tests).
# gtest's patterns of names:
set(kt_long_tests
    # haptics, oracle: two hands on the whole body at a fine rate; the reference's own convergence
    TwoTools.FeelEachOtherAsOnTheWholeBody
    TwoTools.SwappedGiveTheSameForces
    TwoTools.OneThatTouchesNothingChangesNoBit
    TwoTools.StayInTheConeAndOutsideInEveryPair
    FullSimulation.OldMatricesChangeTheForceByLessThanTheStepDoes
    FullSimulation.ConvergesWithTheStep
    # haptics, determinism: runs of every combination of law, tool and link
    Lockstep.LocalModelsAreRunInForFourTicks
    Lockstep.TwoToolsRunAndReplayBitForBit
    Lockstep.LossAndLatencyComeFromTheSeed
    Thread.LockstepReplayOfATurningToolIsTheRun
    Thread.LockstepReplayOfTwoToolsIsTheRun)
# haptics, property: random drags on every mesh, of which those on the block stay; a fine path over the smooth surface
list(APPEND kt_long_tests Meshes/RandomDrags.*/slab_coarse Meshes/RandomDrags.*/sphere
     Meshes/RandomDrags.*/organ SmoothDrag.FeelsNoFoldsOfTheMesh)
list(APPEND kt_long_tests Meshes/SmoothDrags.*/sphere Meshes/SmoothDrags.*/torus Meshes/SmoothDrags.*/organ)
# haptics: materials of the block that have a nonlinear one beside them; broken positions of a point beside those of a sphere
list(APPEND kt_long_tests Meshes/RandomDrags.*/block_linear Meshes/RandomDrags.*/block_stvk
     Meshes/RandomDrags.*/torus All/Method.TakesUpABrokenPosition*_point TwoTools.StayInTheConeAndOutside
     AutoReducer.NeverGetsWorseWhenTheToleranceIsHalved ContactWidth.ForceFactorIsTheOneThatPressesMeasure)
# collision: every pair of features on 1,600 poses; poses known by hand are in the short run
list(APPEND kt_long_tests ToolContacts.TellAsMuchAsAllPairsDo)
# apps: presses of `check` on a broken mesh and on a whole one; the second is in the short run
list(APPEND kt_long_tests Meshes/CheckPress.*/malformed_polygonfaces)
# io: each pair of keys through valijson; every own mesh through every tetrahedralizer
list(APPEND kt_long_tests SceneSchema.ValijsonAndTheWordsAgreeOnGroupsAndPairs
     Tetrahedralize.FillsEveryOwnMeshAndKeepsItsSurface)
# network, property: each has a tenth of it beside it
list(APPEND kt_long_tests ChannelMutations.Million*)
# Scripts, by the name of the file:
set(kt_long_scripts)
# Scripts that run by default with fewer cases, and in full (KT_LONG=1) in the long run:
set(kt_longer_scripts check_command_property_test  # each kind of broken file once, or twice; 20 kills, or 60
                      network_unit_test  # a body that stands still for two times, or for one
                      stop_signals_property_test  # each stage by one signal, or by all
                      tutorials_property_test  # the chart and the advice are left out, or not
                      view_unit_test)  # on a block of a hundred nodes, or on the organ
# network: ten thousand seeds of a link that loses and disorders reports; a thousand are in the short run
list(APPEND kt_long_tests ReportBox.SoItIsForTenThousandSeeds)
# network: mutated messages by the million; twenty thousand are in the short run
list(APPEND kt_long_tests Messages.AMillionMutatedOnesAreReadInRangeOrNotAtAll)
