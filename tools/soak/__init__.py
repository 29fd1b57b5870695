"""The soak: sound arms with worn joints and noisy boards, which no protection may stop.

``kinds.py``     what programs there are, and the settings of each; drawn by a seed
``motions.py``   fast motion: strokes, corners, payloads, excitations
``contacts.py``  tracking, compliance, and the examples in their scenes
``watch.py``     reads every cycle of the six joints beside the nodes
``margins.py``   how near detectors' quantities came to what a fault would make of them
``trial.py``     one program: its run, its trips, its margins, its memory
``results.py``   the file of a campaign
``table.py``     its tables
"""
