"""The paper's figures and sentences, checked: one file an experiment, each handing back a :class:`report.Report`."""
